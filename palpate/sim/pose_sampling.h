// What a person does with the stylus: which poses they reach for, how they turn its marker, how they pull.
//
// One definition for the moving person (sim_person.h) and for laboratories at rest, so that both draw from
// the same poses. World frame, SI. Pure functions; chance comes from the caller's generator. Any thread.
#pragma once

#include <numbers>
#include <optional>

#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::sim {

inline const double kMarkerTilt = radians_from_degrees(40.0);  // largest, of the marker away from the tracker
inline const double kSwingRoll = radians_from_degrees(60.0);   // largest, either way, while swinging
inline const double kAnyRoll = std::numbers::pi;               // of a pose that is only held
inline const double kGimbalReach = radians_from_degrees(75.0);  // second gimbal angle a person uses

Vector3 middle_of_tracker(const config::WorldFile& world);
Vector3 middle_joints(const config::WorldFile& world);

// Uniform over the joint ranges, without poses in which the arm folds up. None where there are hardly any
// others.
std::optional<Vector3> random_joints(const config::WorldFile& world, Random& random);

// The shortest turn that lets `normal` of a body shine towards the tracker.
Quaternion facing(const Vector3& normal, const Vector3& towards);
// Faces the tracker up to a tilt, uniform over the cap, and a roll of up to `roll` either way.
Quaternion random_orientation(const Vector3& normal, const Vector3& towards, double roll, Random& random);

// Direction of a swinging hand's pull: mostly along the stylus, partly down.
Vector3 pull_direction(const Quaternion& R_world_stylus);

}  // namespace palpate::sim
