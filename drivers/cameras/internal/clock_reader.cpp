#include "drivers/cameras/internal/clock_reader.h"

#include <pthread.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "palpate/time/real_time.h"

namespace palpate::drivers::cameras {
namespace {

constexpr int kFirst = 8, kFewest = 4;
constexpr auto kBetweenFirst = std::chrono::milliseconds(25), kStopLook = std::chrono::milliseconds(20);
constexpr double kMostDrift = 1e-3;

// The same clock, later, as far as the two answers can tell.
bool goes_on(const ClockReading& before, const ClockReading& after) {
  const auto camera = static_cast<double>(after.camera_ns - before.camera_ns);
  const auto host = static_cast<double>(after.asked_ns - before.asked_ns);
  const auto unknown =
      static_cast<double>((before.answered_ns - before.asked_ns) + (after.answered_ns - after.asked_ns));
  return camera > 0.0 && std::abs(camera - host) <= unknown + kMostDrift * host;
}

}  // namespace

std::unique_ptr<ClockReader> ClockReader::begin(Read read) {
  std::vector<ClockReading> first;
  for (int i = 0; i < kFirst; ++i) {
    if (i > 0) std::this_thread::sleep_for(kBetweenFirst);
    if (const auto reading = read()) first.push_back(*reading);
    if (static_cast<int>(first.size()) + kFirst - 1 - i < kFewest) return nullptr;
  }
  for (std::size_t i = 1; i < first.size(); ++i)
    if (!goes_on(first[i - 1], first[i])) return nullptr;
  std::unique_ptr<ClockReader> reader(new ClockReader(std::move(read)));
  for (const auto& reading : first) reader->add(reading);
  reader->thread_ = std::thread([self = reader.get()] { self->run(); });
  return reader;
}

ClockReader::~ClockReader() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void ClockReader::add(const ClockReading& reading) {
  const Instant<CameraClock> there{Duration(reading.camera_ns)};
  sync_.add({Duration(reading.asked_ns)}, there, there, {Duration(reading.answered_ns)});
  const std::lock_guard lock(mutex_);
  model_ = sync_.model();
}

void ClockReader::run() {
  pthread_setname_np(pthread_self(), "palpate-cam-clk");
  ask_for_short_turns();  // an answer that lies unread for long tells little
  auto next = std::chrono::steady_clock::now();
  while (!stop_) {
    if (std::chrono::steady_clock::now() < next) {
      std::this_thread::sleep_for(kStopLook);
      continue;
    }
    if (const auto reading = read_()) add(*reading);
    next = std::chrono::steady_clock::now() + sync_.interval();
  }
}

std::int64_t ClockReader::host_ns(std::int64_t camera_ns) const {
  const std::lock_guard lock(mutex_);
  return model_.back({Duration(camera_ns)}).ns();
}

Duration ClockReader::uncertainty(std::int64_t camera_ns) const {
  const std::lock_guard lock(mutex_);
  return model_.uncertainty(model_.back({Duration(camera_ns)}));
}

}  // namespace palpate::drivers::cameras
