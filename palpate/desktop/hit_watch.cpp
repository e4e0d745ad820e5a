#include "palpate/desktop/hit_watch.h"

#include <pthread.h>

#include <chrono>
#include <deque>
#include <optional>

#include "palpate/desktop/hit_detector.h"
#include "palpate/desktop/hit_sound.h"

namespace palpate::desktop {
namespace {

constexpr int kRate_hz = 1000;
constexpr auto kLook = std::chrono::microseconds(500);  // twice a state: none is overtaken
constexpr double kNewest = 0.03;           // of the mean of a lasting force: over some thirty states
constexpr std::size_t kMostWaiting = 512;  // half a second of a force that lasts

}  // namespace

Expected<std::unique_ptr<HitWatch>> HitWatch::begin(const transport::ServerPlace& place,
                                                    std::vector<double> masses,
                                                    std::unique_ptr<SoundOut> sound) {
  auto watch = transport::watch_states(place.endpoint, kRate_hz, place.identity);
  if (!watch) return tl::unexpected(watch.error());
  return std::unique_ptr<HitWatch>(new HitWatch(std::move(*watch), std::move(masses), std::move(sound)));
}

HitWatch::HitWatch(std::unique_ptr<transport::StateWatch> watch, std::vector<double> masses,
                   std::unique_ptr<SoundOut> sound)
    : watch_(std::move(watch)),
      masses_(std::move(masses)),
      sound_(std::move(sound)),
      thread_([this] { run(); }) {}

HitWatch::~HitWatch() {
  stop_ = true;
  thread_.join();
}

void HitWatch::run() {
  ::pthread_setname_np(::pthread_self(), "palpate-hits");
  using Steady = std::chrono::steady_clock;
  HitDetector detector(masses_);
  struct Waiting {
    Steady::time_point due;
    Hit hit;
    double force = 0.0;             // an impact's, now
    std::optional<double> lasting;  // a state's force that lasts
  };
  std::deque<Waiting> waiting;
  const auto raise = [this](double newton) {
    double so_far = force_.load(std::memory_order_relaxed);
    while (newton > so_far && !force_.compare_exchange_weak(so_far, newton, std::memory_order_relaxed)) {
    }
  };
  while (!stop_.load(std::memory_order_relaxed)) {
    const auto now = Steady::now();
    if (const auto reply = watch_->take()) {
      const scene::SceneState& state = reply->answer.state;
      const auto due = now + std::chrono::duration_cast<Steady::duration>(
                                 std::chrono::duration<double>(delay_s_.load(std::memory_order_relaxed)));
      if (const auto hit = detector.look(state); hit && waiting.size() < kMostWaiting)
        waiting.push_back({due, *hit});
      const Vector3 lasting(state.continuous.force.data());
      const double blow = (state.felt_force() - lasting).norm();
      if (waiting.size() < kMostWaiting) waiting.push_back({due, {}, blow, lasting.norm()});
    }
    for (; !waiting.empty() && waiting.front().due <= now; waiting.pop_front()) {
      const Waiting& one = waiting.front();
      raise(one.force);
      if (one.lasting) {
        const double before = lasting_.load(std::memory_order_relaxed);
        // Told as gone when it is: what is left of a mean would be a touch that is not there.
        lasting_.store(*one.lasting > 0.0 ? before + kNewest * (*one.lasting - before) : 0.0,
                       std::memory_order_relaxed);
      }
      if (one.hit.impulse <= 0.0) continue;
      (one.hit.kind == HitKind::hand ? impacts_ : bounces_).fetch_add(1, std::memory_order_relaxed);
      if (sound_) sound_->play(hit_sound(one.hit.kind, one.hit.impulse));
    }
    std::this_thread::sleep_for(kLook);
  }
}

}  // namespace palpate::desktop
