// The paper's Figures 11 and 12: the tracker's and the arm's cloud of points, in the arm's frame, before and
// after.
//
// One laboratory, its 140 poses: before is the absolute orientation alone, after is the joint calibration.
// "Radial" is the part of the difference along the line from the arm's shoulder, where the paper sees it.
#include <cmath>

#include "palpate/core/csv.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/studies/internal/arm_methods.h"
#include "palpate/evaluation/studies/study.h"

namespace palpate::evaluation::studies {
namespace {

struct Clouds {
  std::vector<Vector3> tracker, arm;  // m, ArmBase
  double mean = 0.0;                  // m, distance
  double radial_sd = 0.0;             // m, of the difference along the line from the shoulder
  double radial_slope = 0.0;          // of the radial difference by the distance from the shoulder
};

Clouds clouds_of(const calibration::ArmSolution& arm, const std::vector<device::ArmObservation>& samples) {
  Clouds clouds;
  const auto X_base_world = arm.X_world_base.inverse();
  const Vector3 shoulder(0.0, arm.model.lengths.l2, -arm.model.lengths.l1);
  std::vector<double> radius, along;
  for (const auto& sample : samples) {
    const Vector3 seen = (X_base_world * calibration::measured_tip(arm, sample)).m;
    const Vector3 told = (X_base_world * calibration::predict_tip(arm, sample.joints)).m;
    clouds.tracker.push_back(seen);
    clouds.arm.push_back(told);
    clouds.mean += (told - seen).norm() / static_cast<double>(samples.size());
    radius.push_back((seen - shoulder).norm());
    along.push_back((told - seen).dot((seen - shoulder).normalized()));
  }
  const auto r = summary_of(radius), a = summary_of(along);
  double product = 0.0;
  for (std::size_t i = 0; i < radius.size(); ++i) product += (radius[i] - r.mean) * (along[i] - a.mean);
  clouds.radial_sd = a.sd;
  clouds.radial_slope = product / (static_cast<double>(radius.size() - 1) * r.sd * r.sd);
  return clouds;
}

// Points for a cloud, mm: the tracker's, the arm's with the difference drawn longer, and strokes between the two.
Json drawing(const Clouds& clouds) {
  constexpr double kMagnified = 20.0;
  std::vector<double> seen, told, strokes;
  const auto add = [](std::vector<double>& list, const Vector3& m) {
    for (const double one : m) list.push_back(mm_from_metres(one));
  };
  for (std::size_t i = 0; i < clouds.arm.size(); ++i) {
    const Vector3 moved = clouds.tracker[i] + kMagnified * (clouds.arm[i] - clouds.tracker[i]);
    add(seen, clouds.tracker[i]);
    add(told, moved);
    add(strokes, clouds.tracker[i]);
    add(strokes, moved);
    strokes.insert(strokes.end(), 3, NAN);
  }
  return {{"tracker_mm", seen}, {"arm_mm", told}, {"strokes_mm", strokes}};
}

Json json_of(const Clouds& clouds) {
  return {{"mean_mm", mm_from_metres(clouds.mean)},
          {"radial_sd_mm", mm_from_metres(clouds.radial_sd)},
          {"radial_mm_per_m", mm_from_metres(clouds.radial_slope)}};
}

}  // namespace

Expected<StudyResult> study_clouds(const StudyOptions& options) {
  const auto laboratory = record_laboratory(options.world, repeat_seed(options.seed, "study/clouds", 0));
  if (!laboratory) return tl::unexpected(laboratory.error());
  const auto model = nominal_model(options.world);
  const auto nominal = solve_as(kUncorrected, laboratory->samples, model, laboratory->pivot_tip);
  if (!nominal) return tl::unexpected(nominal.error());
  const auto joint = solve_as(kJoint, laboratory->samples, model, laboratory->pivot_tip);
  if (!joint) return tl::unexpected(joint.error());
  const Clouds before = clouds_of(nominal->value, laboratory->samples);
  const Clouds after = clouds_of(joint->value, laboratory->samples);

  StudyResult study;
  study.name = "clouds";
  study.values = {{"poses", before.arm.size()}, {"before", json_of(before)}, {"after", json_of(after)}};
  CsvWriter csv({"pose", "before_tracker_x_mm", "before_tracker_y_mm", "before_tracker_z_mm",
                 "before_arm_x_mm", "before_arm_y_mm", "before_arm_z_mm", "after_tracker_x_mm",
                 "after_tracker_y_mm", "after_tracker_z_mm", "after_arm_x_mm", "after_arm_y_mm",
                 "after_arm_z_mm"});
  for (std::size_t i = 0; i < before.arm.size(); ++i) {
    std::vector<double> row{static_cast<double>(i + 1)};
    for (const auto* cloud : {&before.tracker, &before.arm, &after.tracker, &after.arm})
      for (const double m : (*cloud)[i]) row.push_back(mm_from_metres(m));
    csv.row(row);
  }
  study.files.emplace_back("clouds.csv", csv.content());
  study.lines.push_back(
      fmt::format("clouds: mean distance {:.3f} -> {:.3f} mm, radial part {:.3f} -> {:.3f} mm sd",
                  mm_from_metres(before.mean), mm_from_metres(after.mean), mm_from_metres(before.radial_sd),
                  mm_from_metres(after.radial_sd)));
  study.page = {{"before", drawing(before)}, {"after", drawing(after)}};
  return study;
}

}  // namespace palpate::evaluation::studies
