// The person in the laboratory: what a calibration procedure may ask them to do.
//
// A real person is asked in words and answers with a key and by what the devices show of them; a simulated one
// acts. Procedures are written against this interface alone and so serve both. One thread.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/device/devices.h"
#include "palpate/math/pose.h"

namespace palpate::device {

enum class Gesture {
  rest,       // let go: the arm in its rest position, the pointer put down
  next_pose,  // hold the stylus still in one more pose, spread over the reach, its marker facing the tracker
  swing_stylus,       // swing the stylus' marker widely around the tip, which the arm or a hollow holds
  wander,             // move the stylus freely through the whole reach, its marker facing the tracker
  swing_pointer,      // swing the pointer widely around its tip, which stands in a divot
  touch,              // hold the pointer's tip on `what` number `index`
  look_around_board,  // move the head widely with the calibration board in view
  look,               // move the head as in use
  // hold the stylus lightly, as a pen, where it will be pushed; `index` 0: about the middle of its reach, then a hand's breadth from there
  // to the left and up, right and up, left and down, right and down
  hold,
};

// Where a person is shown to put the stylus, "here, and turned so"; they will be about there.
struct PoseTarget {
  Point<World> tip;
  Quaternion R_world_marker = Quaternion::Identity();
  Vector3 tip_in_marker = Vector3::Zero();  // as far as it is known: where the marker's pose has the tip
};

struct Request {
  Gesture gesture = Gesture::rest;
  // touch: "table", "wall" (corners, index 0 to 3) or "landmark"; swing_stylus: "hollow", or empty where the arm
  // holds the tip.
  std::string what;
  int index = 0;
  std::optional<PoseTarget> target{};  // next_pose: this one; none: whichever the person likes
  bool known = false;  // touch: a place that is calibrated, of which it is known how many there are
};

class Person {
 public:
  virtual ~Person() = default;
  // Begins a gesture, which lasts until the next request. Refused where there is no such thing to do:
  // ErrorCode::no_more past the last landmark, out_of_reach where the arm does not get to the target.
  virtual Expected<void> ask(const Request& request) = 0;
  // The gesture is over; what was in hand may be put down, and nobody waits for that.
  virtual Expected<void> release() { return ask({}); }
  // Whether the person has got there: holds still, touches, swings. Refused as ask() is, where that shows only
  // now; ErrorCode::stopped: the person breaks off.
  virtual Expected<bool> ready() = 0;
  // How long to wait for that, s; nothing: until the person says otherwise.
  virtual std::optional<double> patience() const { return 60.0; }
  // What the devices have shown in this millisecond. `now_s`: host time.
  virtual void watch(double now_s, const ArmSample& arm, std::span<const TrackerSample> tracked) {
    static_cast<void>(now_s), static_cast<void>(arm), static_cast<void>(tracked);
  }
};

}  // namespace palpate::device
