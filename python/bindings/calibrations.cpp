#include "palpate/calibration/findings/delay.h"
#include "palpate/calibration/findings/hand_eye.h"
#include "palpate/calibration/findings/landmarks.h"
#include "palpate/calibration/findings/pivot.h"
#include "palpate/calibration/findings/points.h"
#include "palpate/calibration/findings/surface.h"
#include "python/bindings/conversions.h"
#include "python/bindings/known_surface.h"
#include "python/bindings/module.h"

namespace palpate::python {
namespace {

namespace findings = calibration::findings;
using MaybeDoubles = std::optional<Doubles>;

calibration::PivotMethod pivot_method(const std::string& name) {
  return name == "sphere"   ? calibration::PivotMethod::sphere
         : name == "robust" ? calibration::PivotMethod::robust
                            : calibration::PivotMethod::algebraic;
}

// `segment`: of each pose the index into `labels`, -1 in none.
py::dict pivot(const Doubles& positions, const Doubles& quaternions, const MaybeDoubles& time_s,
               const Integers& segment, std::vector<std::string> labels, bool find_rests,
               const std::string& method, const MaybeDoubles& given_tip, const MaybeDoubles& motion,
               bool subtract_motion, bool motion_calibrated, bool shared_errors) {
  findings::PivotTask task{.segments = std::move(labels), .find_rests = find_rests};
  const auto places = points_of(positions);
  const auto rotations = quaternions_of(quaternions);
  const auto moved = motion ? points_of(*motion) : std::vector<Vector3>{};
  for (std::size_t i = 0; i < places.size(); ++i)
    task.poses.push_back({rotations[i], places[i], static_cast<int>(segment.data()[i]),
                          motion ? std::optional(moved[i]) : std::nullopt,
                          time_s ? std::optional(time_s->data()[i]) : std::nullopt});
  task.how.method = pivot_method(method);
  task.how.given_tip = point_of(given_tip);
  task.how.with_motion = subtract_motion;
  task.how.shared_errors = shared_errors;
  if (motion_calibrated) task.how.motion_strain = findings::kStrainOfCalibratedArm;
  const auto found = value_or_raise(unlocked([&] { return findings::find_pivot(std::move(task)); }));
  const auto& solution = found.estimate.value;
  auto fields = estimate_fields(found.estimate, found.json);
  std::vector<Vector3> pivots;
  for (const auto& one : solution.segments) pivots.push_back(one.pivot);
  fields["tip"] = list_of(solution.tip);
  fields["pivots"] = rows_of(pivots);
  fields["segments"] = found.segments;
  fields["rotation_range"] = solution.rotation_range;
  return fields;
}

py::dict rigid_motion(const Doubles& from, const Doubles& to, const MaybeDoubles& weights,
                      std::vector<std::string> labels, bool by_label) {
  findings::PointPairs pairs{points_of(from), points_of(to),
                             weights ? numbers_of(*weights) : std::vector<double>{}, std::move(labels),
                             by_label};
  const auto found = value_or_raise(unlocked([&] { return findings::find_rigid_motion(std::move(pairs)); }));
  const auto& motion = found.estimate.value;
  auto fields = estimate_fields(found.estimate, found.json);
  fields["rotation"] = array_of(motion.rotation);
  fields["translation"] = list_of(motion.translation);
  fields["mirrored"] = motion.mirrored;
  return fields;
}

py::dict hand_eye(const Doubles& hand_positions, const Doubles& hand_quaternions,
                  const MaybeDoubles& hand_time, const Doubles& eye_positions, const Doubles& eye_quaternions,
                  const MaybeDoubles& eye_time, bool estimate_delay, double delay_s) {
  calibration::HandEyeOptions how{.estimate_delay = estimate_delay, .delay_s = delay_s};
  if (!hand_time) {
    how.max_hand_gap_s = findings::kRowByRow;
    how.doubt_delay = false;
  }
  auto hand = poses_of(hand_positions, hand_quaternions, hand_time);
  auto eye = poses_of(eye_positions, eye_quaternions, eye_time);
  const auto fit = value_or_raise(
      unlocked([&] { return calibration::calibrate_hand_eye(std::move(hand), std::move(eye), how); }));
  const auto& s = fit.value;
  auto fields = estimate_fields(fit, findings::hand_eye_json(fit));
  fields["camera_in_marker"] = pose_matrix(s.X_marker_camera);
  fields["board_in_world"] = pose_matrix(s.X_world_board);
  fields["delay"] = s.delay_s;
  fields["delay_std"] = s.delay_std_s;
  fields["rms"] = s.translation_rms;
  return fields;
}

py::dict surface_fields(const Estimate<calibration::RectangleFit>& estimate, const Json& json) {
  const auto& fit = estimate.value;
  auto fields = estimate_fields(estimate, json);
  fields["pose"] = pose_matrix(fit.X_world_rectangle);
  std::vector<Vector3> corners;
  for (int corner = 1; corner <= 4; ++corner) corners.push_back(fit.corner(corner).m);
  fields["corners"] = rows_of(corners);
  fields["width"] = fit.width;
  fields["height"] = fit.height;
  rig::SurfaceCalibration surface;
  surface.name = json["name"].get<std::string>();
  surface.X_world_rectangle = fit.X_world_rectangle;
  surface.width = fit.width;
  surface.height = fit.height;
  surface.touch = fit.seen;
  fields["known"] = known_surface(surface);
  return fields;
}

// A tuple of place (N x 3), corner (N, 0 to 4) and name for each surface.
using Touches = std::tuple<std::string, Doubles, Integers>;

py::list surfaces(const std::vector<Touches>& touched, double touch_sd, double touch_freedoms) {
  std::vector<calibration::SurfaceTouches> tasks;
  for (const auto& [name, places, corners] : touched) {
    calibration::SurfaceTouches task{name, {}};
    const auto points = points_of(places);
    for (std::size_t i = 0; i < points.size(); ++i)
      task.points.push_back({{points[i]}, static_cast<int>(corners.data()[i])});
    tasks.push_back(std::move(task));
  }
  const auto found = value_or_raise(unlocked([&] {
    return findings::find_surfaces(std::move(tasks), {.touch = {touch_sd, touch_freedoms}});
  }));
  py::list results;
  for (std::size_t i = 0; i < found.estimates.size(); ++i)
    results.append(surface_fields(found.estimates[i], found.json[i]));
  return results;
}

py::dict landmarks(const Doubles& places, const std::vector<std::string>& labels,
                   const std::vector<KnownSurface>& known, std::optional<double> touch_sd, double tracker_sd,
                   double diameter) {
  std::vector<rig::SurfaceCalibration> surfaces;
  for (const auto& one : known) surfaces.push_back(surface_of(one));
  std::vector<calibration::LandmarkTouch> touches;
  const auto points = points_of(places);
  for (std::size_t i = 0; i < points.size(); ++i)
    touches.push_back({labels[i], points[i], tracker_sd * tracker_sd * Matrix3::Identity()});
  rig::TouchNoise hand = calibration::noise::touch_noise_of(surfaces);
  if (touch_sd) hand = {*touch_sd, findings::kStatedFreedoms};
  const auto found = value_or_raise(unlocked([&] {
    return findings::find_landmarks(std::move(touches), surfaces, {.touch = hand, .diameter = diameter});
  }));
  const auto& value = found.estimate.value;
  auto fields = estimate_fields(found.estimate, found.json);
  std::vector<Vector3> centres, normals;
  for (const auto& landmark : value.landmarks) {
    centres.push_back(landmark.place.m);
    normals.push_back(landmark.normal);
  }
  fields["places"] = rows_of(centres);
  fields["normals"] = rows_of(normals);
  fields["labels"] = value.labels;
  fields["surfaces"] = value.surface;
  return fields;
}

// A recording of a motion: times and, by their number of columns, poses (7: place and quaternion w x y z), points (3) or a
// signal (1).
calibration::Motion motion_of(const std::string& name, const Doubles& time_s, const Doubles& values) {
  const auto times = numbers_of(time_s);
  if (values.shape(1) == 1) return calibration::motion_of_signal(name, times, numbers_of(values));
  if (values.shape(1) == 3) {
    std::vector<calibration::TimedPoint> points;
    const auto places = points_of(values);
    for (std::size_t i = 0; i < times.size(); ++i) points.push_back({times[i], places[i]});
    return calibration::motion_of_points(name, points);
  }
  std::vector<device::StampedPose> poses;
  const double* at = values.data();
  for (std::size_t i = 0; i < times.size(); ++i, at += 7) {
    device::StampedPose pose;
    pose.time_s = times[i];
    pose.translation = Vector3(at[0], at[1], at[2]);
    pose.rotation = Quaternion(at[3], at[4], at[5], at[6]);
    poses.push_back(pose);
  }
  return calibration::motion_of_poses(name, poses);
}

py::dict delay(const std::string& from_name, const Doubles& from_time, const Doubles& from,
               const std::string& to_name, const Doubles& to_time, const Doubles& to,
               std::optional<double> longest_s) {
  const auto first = motion_of(from_name, from_time, from), second = motion_of(to_name, to_time, to);
  calibration::MotionDelayOptions how;
  if (longest_s) how.longest_s = *longest_s;
  const auto found =
      value_or_raise(unlocked([&] { return calibration::estimate_motion_delay(first, second, how); }));
  py::dict fields;
  fields["json"] = object_of(findings::delay_json(found, found.warnings));
  fields["delay"] = found.delay_s;
  fields["std"] = found.delay_std_s;
  fields["correlation"] = found.correlation;
  fields["overlap"] = found.overlap_s;
  return fields;
}

}  // namespace

void add_calibrations(py::module_& module) {
  module.def("pivot", &pivot);
  module.def("rigid_motion", &rigid_motion);
  module.def("hand_eye", &hand_eye);
  module.def("surfaces", &surfaces);
  module.def("landmarks", &landmarks);
  module.def("delay", &delay);
  module.attr("PRESUMED_TOUCH") =
      py::make_tuple(calibration::noise::kPresumedTouch.sd, calibration::noise::kPresumedTouch.freedoms);
}

}  // namespace palpate::python
