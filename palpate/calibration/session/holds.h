// When a marker was held still, found in what the tracker saw: nobody has to say when.
//
// A hold begins as Stillness says: seen and still for its window, and moved since the hold before. It lasts while the marker is seen
// and stays within twice `place` and `turn` of the hold's mean so far: a hand trembles, and what one frame more or less is off tells nothing.
// A glimpse lost, or a frame that is off, does not end it within `bridged_s`; frames that are off are left out. Both ends are cut off by `trim_s`,
// in which a hand settles and sets off. A marker at rest anywhere, in the air or put down on a table, is a hold as well: only who held
// it knows better. Poses as of DeviceStreams: World (or a reference body), m, rad, host time, in its order. Pure.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "palpate/calibration/session/procedures.h"
#include "palpate/calibration/session/stillness.h"

namespace palpate::calibration::session {

struct HoldSettings {
  StillnessSettings still;
  double bridged_s = 0.25, trim_s = 0.05;
  double least_s = 0.25;   // what is left of a shorter one tells nothing
  std::size_t fewest = 5;  // seen poses in it
};

// The seen poses of one hold, in their order.
using Hold = std::vector<TrackedPose>;

// `poses` of one marker, seen and unseen.
std::vector<Hold> find_holds(const std::vector<TrackedPose>& poses, const HoldSettings& settings = {});

// One pose for a hold: the means of place, turn, readings and time. Its covariance is that of the mean of poses whose noise is
// white; the systematic part stays.
TrackedPose mean_pose(const Hold& hold);

// A tip at `tip` in the marker, held on a place.
struct HeldTouch {
  Vector3 place = Vector3::Zero();       // mean over the hold
  Matrix3 covariance = Matrix3::Zero();  // of the mean, as the tracker believes, m^2
  Matrix3 scatter = Matrix3::Zero();     // of single poses about the mean, m^2: noise and the hand's tremor
  std::size_t frames = 0;
  double from_s = 0.0, to_s = 0.0;
};
HeldTouch touch_of(const Hold& hold, const Vector3& tip);

// The holds that somebody meant who said at `keys_s` that the tip is there: for each the hold that lasts then, or else the next that
// begins within `patience_s` and before the next key. Each hold once. `missed` counts keys without one.
std::vector<Hold> holds_at(const std::vector<Hold>& holds, const std::vector<double>& keys_s,
                           std::size_t& missed, double patience_s = 5.0);

}  // namespace palpate::calibration::session
