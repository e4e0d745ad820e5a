// The paper's Figures 7, 8 and 9: what the arm's calibration reaches with how many points.
//
// Each laboratory is a draw of the world: 140 poses, of which random halves train and test, as in the paper.
// Several splits share a laboratory, its recording and its bound. More than half of the poses are tested on
// 70 further ones.
#include "palpate/studies/points_study.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/studies/arm_laboratory.h"
#include "palpate/studies/paper_values.h"

namespace palpate {
namespace {

constexpr std::size_t kSplits = kRunsPerLaboratory;  // of each laboratory's recording
constexpr int kLengthsCount = 70;                    // points with which lengths are freed too
constexpr std::array kLengthMethods{kEq7, kJoint};

struct Outcome {
  std::string world, method;
  int count = 0;
  double held_out_mm = kNoValue, truth_mm = kNoValue, truth_rms_mm = kNoValue;
  Vector3 gain_error = Vector3::Constant(kNoValue), offset_error_deg = Vector3::Constant(kNoValue);
  Vector3 length_error_mm = Vector3::Constant(kNoValue);  // l1, l2, -; only where freed
};

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// What one laboratory gives for its splits.
struct Trial {
  const StudyOptions& options;
  const ArmLaboratory& laboratory;
  std::string world;
  std::vector<Outcome>& outcomes;

  void add(std::string_view method, const std::vector<ArmObservation>& train,
           const std::vector<ArmObservation>& test, bool free_lengths = false) {
    ArmOptions arm;
    arm.free.lengths = free_lengths;
    arm.tip = laboratory.pivot_tip;
    arm.method = method == kOnePass       ? ArmMethod::one_pass
                 : method == kAlternating ? ArmMethod::alternating
                 : method == kEq7         ? ArmMethod::eq7
                                          : ArmMethod::joint;
    const ArmModel model = nominal_model(options.world);
    const auto estimate =
        method == kUncorrected ? uncorrected_arm(train, model, arm) : calibrate_arm(train, model, arm);
    Outcome outcome{world, std::string(method), static_cast<int>(train.size())};
    if (estimate) {
      const auto errors = errors_to_truth(estimate->value, laboratory);
      const auto& truth = laboratory.truth;
      outcome.held_out_mm = mm_from_metres(mean_norm(arm_errors(estimate->value, test)));
      outcome.truth_mm = mm_from_metres(mean(errors));
      outcome.truth_rms_mm = mm_from_metres(rms(errors));
      outcome.gain_error = estimate->value.gain - truth.joints.gain;
      outcome.offset_error_deg = kDegreesPerRadian * (estimate->value.offset - truth.joints.offset);
      const auto& lengths = estimate->value.model.lengths;
      if (free_lengths)
        outcome.length_error_mm = {mm_from_metres(lengths.l1 - truth.lengths.l1),
                                   mm_from_metres(lengths.l2 - truth.lengths.l2), 0.0};
    }
    if (free_lengths) outcome.method += ", lengths free";
    outcomes.push_back(std::move(outcome));
  }

  void add_bound(const std::vector<ArmObservation>& train) {
    const auto arm = laboratory.arm();
    const auto C = parameter_bound(arm, bound_samples(train), TipIs::estimated);
    Outcome outcome{world, std::string(kBound), static_cast<int>(train.size())};
    if (C.allFinite()) {
      outcome.truth_rms_mm = mm_from_metres(workspace_bound(arm, C, laboratory.judged));
      for (Eigen::Index j = 0; j < 3; ++j) {
        outcome.gain_error[j] = std::sqrt(C(kBoundGains + j, kBoundGains + j));
        if (j > 0)
          outcome.offset_error_deg[j] =
              kDegreesPerRadian * std::sqrt(C(kBoundOffsets + j - 1, kBoundOffsets + j - 1));
      }
    }
    outcomes.push_back(std::move(outcome));
  }
};

// The samples in a random order: the first half trains, the second tests.
std::vector<std::size_t> shuffled(std::size_t count, Random& random) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

Expected<std::vector<Outcome>> try_laboratory(const StudyOptions& options, std::size_t number,
                                              std::size_t splits) {
  std::vector<Outcome> outcomes;
  const std::uint64_t seed = repeat_seed(options.seed, "study/points", number);
  for (const bool white : {false, true}) {
    const auto world = white ? white_world(options.world) : options.world;
    const auto laboratory = record_laboratory(world, seed);
    if (!laboratory) return tl::unexpected(laboratory.error());
    Trial trial{options, *laboratory, white ? "white" : "reference", outcomes};
    Random random(seed, "study/splits");
    const auto half = laboratory->samples.size() / 2;
    // The bound is set against one split of each laboratory: splits of one recording share their noise.
    for (std::size_t split = 0; split < (white ? 1 : splits); ++split) {
      const auto order = shuffled(laboratory->samples.size(), random);
      for (const int points : kPointCounts) {
        const auto count = static_cast<std::size_t>(points);
        // All of them are the same set in every split, and what is above half of them nearly.
        if (count > half && split > 0) continue;
        std::vector<ArmObservation> train, test;
        for (std::size_t i = 0; i < count; ++i) train.push_back(laboratory->samples[order[i]]);
        for (std::size_t i = half; i < order.size(); ++i) test.push_back(laboratory->samples[order[i]]);
        if (count > half) test = laboratory->unused;
        if (!white)
          for (const std::string_view method : {kUncorrected, kOnePass, kAlternating, kEq7})
            trial.add(method, train, test);
        trial.add(kJoint, train, test);
        if (white) trial.add_bound(train);
        if (!white && split == 0 && points == kLengthsCount)
          for (const std::string_view method : kLengthMethods) trial.add(method, train, test, true);
      }
    }
  }
  return outcomes;
}

using Pick = std::function<double(const Outcome&)>;

Summary pick(const std::vector<Outcome>& outcomes, std::string_view world, std::string_view method, int count,
             const Pick& value) {
  std::vector<double> values;
  for (const auto& o : outcomes)
    if (o.count == count && o.world == world && o.method == method) values.push_back(value(o));
  return summary_of(values);
}

Curve curve(const std::vector<Outcome>& outcomes, std::string figure, std::string_view world,
            std::string_view method, std::string label, std::string y_name, const Pick& value) {
  Curve curve{std::move(figure), std::move(label), "points", std::move(y_name), {}};
  for (const int count : kPointCounts)
    curve.points.push_back({static_cast<double>(count), pick(outcomes, world, method, count, value)});
  return curve;
}

std::vector<Curve> curves_of(const std::vector<Outcome>& outcomes) {
  std::vector<Curve> curves;
  for (const std::string_view method : {kUncorrected, kOnePass, kAlternating, kEq7, kJoint}) {
    curves.push_back(curve(outcomes, "held-out error", "reference", method, std::string(method), "error_mm",
                           [](const Outcome& o) { return o.held_out_mm; }));
    curves.push_back(curve(outcomes, "error to truth", "reference", method, std::string(method), "error_mm",
                           [](const Outcome& o) { return o.truth_mm; }));
  }
  for (const std::string_view method : {kJoint, kBound})
    curves.push_back(curve(outcomes, "error to truth, white world", "white", method, std::string(method),
                           "rms_error_mm", [](const Outcome& o) { return o.truth_rms_mm; }));
  for (Eigen::Index j = 0; j < 3; ++j) {
    const Pick gain = [j](const Outcome& o) { return o.gain_error[j]; };
    const Pick offset = [j](const Outcome& o) { return o.offset_error_deg[j]; };
    for (const std::string_view method : {kEq7, kJoint}) {
      curves.push_back(curve(outcomes, "offset error", "reference", method,
                             fmt::format("gamma{}, {}", j + 1, method), "error_deg", offset));
      curves.push_back(curve(outcomes, "gain error", "reference", method,
                             fmt::format("k{}, {}", j + 1, method), "error", gain));
    }
    for (const std::string_view method : {kJoint, kBound}) {
      if (j > 0)
        curves.push_back(curve(outcomes, "offset error, white world", "white", method,
                               fmt::format("gamma{}, {}", j + 1, method), "error_deg", offset));
      curves.push_back(curve(outcomes, "gain error, white world", "white", method,
                             fmt::format("k{}, {}", j + 1, method), "error", gain));
    }
  }
  return curves;
}

double at(const Curve& curve, int count, Drawn drawn) {
  for (const auto& point : curve.points)
    if (point.x == count) return drawn == Drawn::rms ? point.y.rms : point.y.mean;
  return kNoValue;
}

void add_key_figures(StudyResult& study, const std::vector<Outcome>& outcomes) {
  study.values["paper"] = {{"before_mm", paper::kBefore_mm},
                           {"after_mm", paper::kAfter_mm},
                           {"enough_points", paper::kEnoughPoints},
                           {"source", "section 4.4.2, Figure 7"}};
  for (const char* figure : {"held-out error", "error to truth"}) {
    Json by_method;
    std::string line = fmt::format("{}, 70 points:", figure);
    for (const std::string_view method : {kUncorrected, kOnePass, kAlternating, kEq7, kJoint}) {
      const double value = at(curve_named(study.curves, figure, method), 70, Drawn::mean);
      by_method[std::string(method)] = value;
      line += fmt::format("  {} {:.3f} mm", method, value);
    }
    study.values["at_70_points"][figure] = by_method;
    study.lines.push_back(line);
  }
  Json ratios = Json::array();
  for (const int count : kBoundCounts) {
    const auto& ours = curve_named(study.curves, "error to truth, white world", kJoint);
    const auto& bound = curve_named(study.curves, "error to truth, white world", kBound);
    const double a = at(ours, count, Drawn::rms), b = at(bound, count, Drawn::rms);
    const int laboratories =
        pick(outcomes, "white", kBound, 140, [](const auto& o) { return o.truth_rms_mm; }).runs;
    ratios.push_back({{"points", count},
                      {"ours_rms_mm", a},
                      {"bound_rms_mm", b},
                      {"ratio", a / b},
                      {"laboratories", laboratories}});
    study.lines.push_back(
        fmt::format("white world, {} points: rms {:.4f} mm, Cramer-Rao bound {:.4f} mm, ratio {:.3f} "
                    "({} laboratories)",
                    count, a, b, a / b, laboratories));
  }
  study.values["cramer_rao"] = ratios;
  for (const std::string_view method : kLengthMethods) {
    const std::string name = fmt::format("{}, lengths free", method);
    Json lengths;
    for (Eigen::Index j = 0; j < 2; ++j) {
      const auto error = pick(outcomes, "reference", name, kLengthsCount,
                              [j](const Outcome& o) { return o.length_error_mm[j]; });
      lengths[fmt::format("l{}_error_mm", j + 1)] = {{"mean", error.mean}, {"sd", error.sd}};
    }
    lengths["error_to_truth_mm"] =
        pick(outcomes, "reference", name, kLengthsCount, [](const Outcome& o) { return o.truth_mm; }).mean;
    study.values["lengths_free"][std::string(method)] = lengths;
  }
}

}  // namespace

Expected<StudyResult> study_points(const StudyOptions& options) {
  const auto runs = static_cast<std::size_t>(options.runs);
  const std::size_t laboratories = (runs + kSplits - 1) / kSplits;
  std::vector<Expected<std::vector<Outcome>>> slots(laboratories);
  repeat(laboratories, options.repeats, [&](std::size_t i) {
    slots[i] = try_laboratory(options, i, std::min(kSplits, runs - i * kSplits));
  });
  std::vector<Outcome> outcomes;
  for (auto& slot : slots) {
    if (!slot) return tl::unexpected(slot.error());
    outcomes.insert(outcomes.end(), slot->begin(), slot->end());
  }
  StudyResult study;
  study.name = "points";
  study.curves = curves_of(outcomes);
  add_key_figures(study, outcomes);
  study.tell = [copy = StudyResult{study.name, study.curves, study.values, {}, {}, {}}](
                   report::Report& page) { tell_points(page, copy); };
  return study;
}

}  // namespace palpate
