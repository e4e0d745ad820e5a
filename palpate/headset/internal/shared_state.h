// What the thread of a headset shares with those who use it, and outlives both: each holds it.
//
// The mutex is held for moments, never while pixels are copied or the runtime is asked.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>

#include "palpate/headset/headset.h"

namespace palpate::headset {

// As OpenGL takes them: row 0 is the lowest.
struct Pixels {
  std::vector<std::uint8_t> bytes;
  int width = 0, height = 0;
};

struct HandedPicture {
  Pixels pixels;  // red, green, blue
  std::uint64_t number = 0;
  Instant<GraphicsClock> image_time;
  double distance = 0.0;
};

struct HandedPanel {
  Pixels pixels;  // red, green, blue, cover; without a width: no panel
  double wide = 0.0;
  Vector3 middle = Vector3::Zero();
};

struct SharedState {
  explicit SharedState(const HeadsetSettings& chosen) : settings(chosen) {}

  const HeadsetSettings settings;
  HeadHistory history;  // written by the headset's thread
  std::atomic<std::uint64_t> beats{
      0};  // of that thread, while a runtime is there: it stands still when that hangs
  std::atomic<bool> stopping{false};
  std::atomic<void*> runtime_code{nullptr};  // a function of the runtime's library, while that is loaded

  mutable std::mutex mutex;
  std::condition_variable changed;
  // Under the mutex:
  HeadsetFacts facts;
  std::optional<Error> failure;  // of the last attempt to reach a runtime
  std::uint64_t attempts = 0;    // that have ended, one way or the other
  bool ended = false;            // the thread has nothing left to do
  std::optional<Headset::Shown> shown;
  std::unique_ptr<HandedPicture> picture, spare_picture;  // handed over and not taken up; to be written next
  std::unique_ptr<HandedPanel> panel;

  Instant<GraphicsClock> now() const { return settings.clock.from_monotonic(settings.monotonic_ns()); }
};

}  // namespace palpate::headset
