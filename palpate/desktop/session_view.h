// What a guided session shows in its window at a moment, and how it gets from the session's thread to the window's.
//
// SessionView is a value. SessionExchange may be used from two threads: the session's changes the view and takes keys,
// the window's copies the view and brings keys; its mutex is held for moments.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/calibration/session/session_panel.h"
#include "palpate/device/person.h"
#include "palpate/rig/rig.h"

namespace palpate::desktop {

// A camera's picture with where the camera's marker was when it was taken.
struct SessionPicture {
  device::CameraImage image;
  bool right = false;  // of two cameras
  calibration::session::SeenMarker marker;
};

struct SessionView {
  std::size_t step = 0, steps = 0;  // from 0; no steps: it has not begun
  std::string step_name;
  std::optional<device::Request> request;  // none: nothing is asked for yet
  std::string instruction, progress;
  calibration::session::PersonView person;
  int taken = 0;                  // poses, touches or movements of this step
  std::optional<double> taken_s;  // the last of them, of the newest request; PersonView::now_s
  std::vector<Vector3> held;      // tips in the poses taken in this step, World, m
  std::vector<calibration::session::GuidanceState> guidance;  // after each pose of this step
  int guided_of = 0;
  std::optional<calibration::session::StepOutcome> outcome;  // while it is reviewed
  std::shared_ptr<const rig::Rig> rig;
  std::shared_ptr<const SessionPicture> picture;
  bool ending = false;  // the window has been closed

  // Changed by every change of the rest.
  std::uint64_t version = 0;
};

class SessionExchange {
 public:
  // The session's thread.
  void change(const std::function<void(SessionView&)>& how) {
    const std::lock_guard lock(mutex_);
    how(view_);
    ++view_.version;
  }
  std::optional<char> take_key() {
    const std::lock_guard lock(mutex_);
    if (keys_.empty()) return std::nullopt;
    const char key = keys_.front();
    keys_.pop_front();
    return key;
  }

  // The window's thread.
  SessionView view() const {
    const std::lock_guard lock(mutex_);
    return view_;
  }
  void press(char key) {
    const std::lock_guard lock(mutex_);
    if (keys_.size() < kMostKeys) keys_.push_back(key);
  }

 private:
  static constexpr std::size_t kMostKeys = 64;
  mutable std::mutex mutex_;
  SessionView view_;
  std::deque<char> keys_;
};

}  // namespace palpate::desktop
