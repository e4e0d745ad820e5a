// A camera's own clock beside the host's, by asking: the camera reads it between a question and an answer. How long its pictures
// are on their way, and what else this machine does when they come, is not in it.
//
// Asks in a thread of its own, often at first and then ten times a second (ClockSync). Host times:
// CLOCK_MONOTONIC, ns.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "palpate/time/clock_model.h"
#include "palpate/time/instant.h"

namespace palpate::drivers::cameras {

struct ClockReading {
  std::int64_t asked_ns = 0, answered_ns = 0;  // host
  std::int64_t camera_ns = 0;                  // somewhere between them
};

class ClockReader {
 public:
  // One question; nothing where there is no answer. May wait for it.
  using Read = std::function<std::optional<ClockReading>()>;

  // Asks some times at once, for 0.2 s. Null where the camera does not tell, or what it tells is no clock: it stands still, or
  // goes otherwise than the host's by more than 1 in 1000.
  static std::unique_ptr<ClockReader> begin(Read read);
  ~ClockReader();  // waits for an answer that is due
  ClockReader(const ClockReader&) = delete;
  ClockReader& operator=(const ClockReader&) = delete;

  // Any thread. Where answers fail to come the clock is taken to go on as it went.
  std::int64_t host_ns(std::int64_t camera_ns) const;
  // How far that may be from the truth.
  Duration uncertainty(std::int64_t camera_ns) const;

 private:
  explicit ClockReader(Read read) : read_(std::move(read)) {}
  void add(const ClockReading& reading);
  void run();

  Read read_;
  ClockSync<GraphicsClock, CameraClock> sync_;  // before `thread_` begins, and then of it
  mutable std::mutex mutex_;
  ClockModel<GraphicsClock, CameraClock> model_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace palpate::drivers::cameras
