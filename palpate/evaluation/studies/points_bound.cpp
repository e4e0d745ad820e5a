// White noise and the Cramer-Rao bound, and whether the regions that the calibration states hold the truth.
// Each run has a laboratory of its own, so that the runs are independent.
#include <algorithm>
#include <cmath>

#include "palpate/core/units.h"
#include "palpate/evaluation/studies/internal/points_study.h"
#include "palpate/evaluation/studies/internal/stated_regions.h"

namespace palpate::evaluation::studies {
namespace {

constexpr int kBoundJudged = 100;

struct BoundOutcome {
  bool tried = false;
  double truth_rms_mm = kNoValue, bound_rms_mm = kNoValue;
  Vector3 gain_error = Vector3::Constant(kNoValue), gain_bound = Vector3::Constant(kNoValue);
  Vector3 offset_error_deg = Vector3::Constant(kNoValue), offset_bound_deg = Vector3::Constant(kNoValue);
  double places_inside = kNoValue, tip_inside = kNoValue;  // share; 0 or 1
};

constexpr bool in(const auto& counts, int count) {
  for (const int c : counts)
    if (c == count) return true;
  return false;
}

// A bound's square: bounds of different laboratories are averaged as variances.
void add_bound_of(const ArmLaboratory& laboratory, const std::vector<device::ArmObservation>& train,
                  BoundOutcome& outcome) {
  const auto arm = laboratory.arm();
  const auto C = parameter_bound(arm, bound_samples(train), TipIs::estimated);
  if (!C.allFinite()) return;
  outcome.bound_rms_mm = mm_from_metres(workspace_bound(arm, C, laboratory.judged));
  for (Eigen::Index j = 0; j < 3; ++j) {
    outcome.gain_bound[j] = std::sqrt(C(kBoundGains + j, kBoundGains + j));
    if (j > 0)
      outcome.offset_bound_deg[j] =
          kDegreesPerRadian * std::sqrt(C(kBoundOffsets + j - 1, kBoundOffsets + j - 1));
  }
}

using BoundRun = std::array<BoundOutcome, kWhiteCounts.size()>;

Expected<BoundRun> try_run(const StudyOptions& options, const sim::config::WorldFile& world, bool white,
                           std::size_t number) {
  LaboratorySettings settings;
  settings.unused = 0;
  settings.judged = kBoundJudged;
  settings.swing = 0;  // ours finds the tip by itself
  if (!white) settings.samples = kHalf;
  const auto laboratory =
      record_laboratory(world, repeat_seed(options.seed, "study/bound", number), settings);
  if (!laboratory) return tl::unexpected(laboratory.error());
  const auto model = nominal_model(world);
  BoundRun run;
  for (std::size_t c = 0; c < kWhiteCounts.size(); ++c) {
    const int count = kWhiteCounts[c];
    if (count > settings.samples || (!white && !in(kCoverageCounts, count))) continue;
    const std::vector<device::ArmObservation> train(laboratory->samples.begin(),
                                                    laboratory->samples.begin() + count);
    BoundOutcome& outcome = run[c];
    outcome.tried = true;
    if (white) add_bound_of(*laboratory, train, outcome);
    const auto solved = solve_as(kJoint, train, model, laboratory->pivot_tip,
                                 {.full_covariance = in(kCoverageCounts, count)});
    if (!solved) continue;
    const auto& arm = solved->value;
    outcome.truth_rms_mm = mm_from_metres(summary_of(errors_to_truth(arm, *laboratory)).rms);
    outcome.gain_error = arm.gain - laboratory->truth.joints.gain;
    outcome.offset_error_deg = kDegreesPerRadian * (arm.offset - laboratory->truth.joints.offset);
    if (!in(kCoverageCounts, count)) continue;
    outcome.places_inside = share_of_places_inside(*solved, *laboratory);
    outcome.tip_inside = tip_inside(*solved, laboratory->truth.tip_in_marker) ? 1.0 : 0.0;
  }
  return run;
}

template <typename Pick>
Summary over_runs(const std::vector<BoundRun>& runs, std::size_t count, const Pick& pick) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const auto& run : runs)
    if (run[count].tried) values.push_back(pick(run[count]));
  return summary_of(values);
}

bool tried(const std::vector<BoundRun>& runs, std::size_t count) {
  return std::any_of(runs.begin(), runs.end(), [count](const auto& run) { return run[count].tried; });
}

template <typename Counts, typename Pick>
Curve bound_curve(const std::vector<BoundRun>& runs, const Counts& counts, std::string figure,
                  std::string label, std::string y_name, const Pick& pick) {
  Curve curve{std::move(figure), std::move(label), "points", std::move(y_name), {}};
  for (std::size_t c = 0; c < kWhiteCounts.size(); ++c)
    if (in(counts, kWhiteCounts[c]) && tried(runs, c))
      curve.points.push_back({static_cast<double>(kWhiteCounts[c]), over_runs(runs, c, pick)});
  return curve;
}

void add_white_curves(StudyResult& study, const std::vector<BoundRun>& runs) {
  const auto add = [&](const char* figure, std::string label, const char* y, const auto& pick) {
    study.curves.push_back(bound_curve(runs, kWhiteCounts, figure, std::move(label), y, pick));
  };
  add("error to truth, white world", std::string(kJoint), "rms_error_mm",
      [](const BoundOutcome& o) { return o.truth_rms_mm; });
  add("error to truth, white world", std::string(kBound), "rms_error_mm",
      [](const BoundOutcome& o) { return o.bound_rms_mm; });
  for (Eigen::Index j = 0; j < 3; ++j) {
    add("gain error, white world", fmt::format("k{}, {}", j + 1, kJoint), "error",
        [j](const BoundOutcome& o) { return o.gain_error[j]; });
    add("gain error, white world", fmt::format("k{}, {}", j + 1, kBound), "error",
        [j](const BoundOutcome& o) { return o.gain_bound[j]; });
    if (j == 0) continue;
    add("offset error, white world", fmt::format("gamma{}, {}", j + 1, kJoint), "error_deg",
        [j](const BoundOutcome& o) { return o.offset_error_deg[j]; });
    add("offset error, white world", fmt::format("gamma{}, {}", j + 1, kBound), "error_deg",
        [j](const BoundOutcome& o) { return o.offset_bound_deg[j]; });
  }
  Json ratios = Json::array();
  for (const auto& bar : kBoundBars) {
    const auto ours = curve_named(study.curves, "error to truth, white world", kJoint).at(bar.points);
    const auto bound = curve_named(study.curves, "error to truth, white world", kBound).at(bar.points);
    const double ratio = ours.rms / bound.rms;
    ratios.push_back({{"points", bar.points},
                      {"ours_rms_mm", number_or_null(ours.rms)},
                      {"bound_rms_mm", number_or_null(bound.rms)},
                      {"ratio", number_or_null(ratio)},
                      {"most", bar.most},
                      {"laboratories", bound.runs}});
    study.lines.push_back(
        fmt::format("white world, {} points: rms {:.4f} mm, Cramer-Rao bound {:.4f} mm, ratio {:.3f} "
                    "({} laboratories)",
                    bar.points, ours.rms, bound.rms, ratio, bound.runs));
  }
  study.values["cramer_rao"] = ratios;
}

void add_coverage(StudyResult& study, std::string_view world, const std::vector<BoundRun>& runs) {
  const auto figure = figure_of("stated 95 % regions", world);
  study.curves.push_back(bound_curve(runs, kCoverageCounts, figure, "tip at unseen places", "share_inside",
                                     [](const BoundOutcome& o) { return o.places_inside; }));
  study.curves.push_back(bound_curve(runs, kCoverageCounts, figure, "tip in the marker", "share_inside",
                                     [](const BoundOutcome& o) { return o.tip_inside; }));
  Json rows = Json::array();
  for (const int count : kCoverageCounts) {
    if (world != "white" && count > kHalf) continue;
    const auto places = curve_named(study.curves, figure, "tip at unseen places").at(count);
    const auto tip = curve_named(study.curves, figure, "tip in the marker").at(count);
    rows.push_back({{"points", count},
                    {"unseen_places", number_or_null(places.mean)},
                    {"tip_in_marker", number_or_null(tip.mean)},
                    {"runs", places.runs}});
    study.lines.push_back(fmt::format(
        "{} world, {} points: 95 % regions hold the tip at unseen places in {:.1f} %, the tip in the marker "
        "in {:.1f} % of {} runs",
        world, count, 100.0 * places.mean, 100.0 * tip.mean, places.runs));
  }
  study.values["coverage"][std::string(world)] = rows;
}

}  // namespace

Expected<void> add_bound(StudyResult& study, const StudyOptions& options) {
  const auto runs = static_cast<std::size_t>(options.runs);
  const std::array worlds{white_world(options.world), options.world};
  std::vector<Expected<BoundRun>> slots(2 * runs);
  repeat(slots.size(), options.repeats,
         [&](std::size_t i) { slots[i] = try_run(options, worlds[i / runs], i < runs, i % runs); });
  std::array<std::vector<BoundRun>, 2> by_world;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (!slots[i]) return tl::unexpected(slots[i].error());
    by_world[i / runs].push_back(*slots[i]);
  }
  add_white_curves(study, by_world[0]);
  add_coverage(study, "white", by_world[0]);
  add_coverage(study, "reference", by_world[1]);
  return {};
}

}  // namespace palpate::evaluation::studies
