// Figure 7: each laboratory is a draw of the world, 140 poses, of which random halves train and test, as in
// the paper. Several splits share a laboratory. More than half of the poses are tested on 70 further ones.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/studies/internal/paper_values.h"
#include "palpate/evaluation/studies/internal/points_study.h"

namespace palpate::evaluation::studies {
namespace {

constexpr std::array kSplitMethods{kUncorrected, kOnePass, kAlternating, kEq7, kJoint, kNoiseFloor};

// Other choices of what is free, with kVariantCount points and one split of each laboratory.
struct SplitVariant {
  std::string_view name, method;
  Lengths lengths;
  bool gains;
};
constexpr std::array<SplitVariant, 6> kVariants{
    {{"paper: equations 7, 8", kEq7, Lengths::free, true},
     {"paper: equations 7, 8, lengths held", kEq7, Lengths::held, true},
     {"paper: equations 7, 8, gains held at 1", kEq7, Lengths::free, false},
     {"ours: joint with tip", kJoint, Lengths::held, true},
     {"ours: joint with tip, lengths free", kJoint, Lengths::free, true},
     {"ours: joint with tip, gains held at 1", kJoint, Lengths::held, false}}};

struct SplitOutcome {
  double held_out_mm = kNoValue, truth_mm = kNoValue, residual_mm = kNoValue;
  Vector3 gain_error = Vector3::Constant(kNoValue), offset_error_deg = Vector3::Constant(kNoValue);
  Eigen::Vector2d length_error_mm = Eigen::Vector2d::Constant(kNoValue);
};

struct SplitOutcomes {
  std::array<std::array<std::vector<SplitOutcome>, kPointCounts.size()>, kSplitMethods.size()> tried;
  std::array<std::vector<SplitOutcome>, kVariants.size()> variants;
};

SplitOutcome judged(const calibration::ArmSolution& arm, const ArmLaboratory& laboratory,
                    const std::vector<device::ArmObservation>& test) {
  const auto errors = errors_to_truth(arm, laboratory);
  const auto& truth = laboratory.truth;
  SplitOutcome outcome;
  outcome.held_out_mm = mm_from_metres(mean_norm(calibration::arm_errors(arm, test)));
  outcome.truth_mm =
      mm_from_metres(std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size()));
  outcome.gain_error = arm.gain - truth.joints.gain;
  outcome.offset_error_deg = kDegreesPerRadian * (arm.offset - truth.joints.offset);
  outcome.length_error_mm = {mm_from_metres(arm.model.lengths.l1 - truth.lengths.l1),
                             mm_from_metres(arm.model.lengths.l2 - truth.lengths.l2)};
  return outcome;
}

// The samples in a random order: the first half trains, the second tests.
std::vector<std::size_t> shuffled(std::size_t count, Random& random) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

std::vector<device::ArmObservation> chosen(const std::vector<device::ArmObservation>& samples,
                                           const std::vector<std::size_t>& order, std::size_t from,
                                           std::size_t to) {
  std::vector<device::ArmObservation> result;
  result.reserve(to - from);
  for (std::size_t i = from; i < to; ++i) result.push_back(samples[order[i]]);
  return result;
}

Expected<SplitOutcomes> try_laboratory(const StudyOptions& options, std::size_t number, std::size_t splits) {
  const std::uint64_t seed = repeat_seed(options.seed, "study/points", number);
  const auto laboratory = record_laboratory(options.world, seed);
  if (!laboratory) return tl::unexpected(laboratory.error());
  const auto model = nominal_model(options.world);
  const auto perfect = true_solution(*laboratory);
  const auto& samples = laboratory->samples;
  SplitOutcomes outcomes;
  Random random(seed, "study/splits");
  for (std::size_t split = 0; split < splits; ++split) {
    const auto order = shuffled(samples.size(), random);
    const auto tested = chosen(samples, order, kHalf, samples.size());
    for (std::size_t c = 0; c < kPointCounts.size(); ++c) {
      const auto count = static_cast<std::size_t>(kPointCounts[c]);
      // All of them are the same set in every split, and what is above half of them nearly.
      if (count > kHalf && split > 0) continue;
      const auto train = chosen(samples, order, 0, count);
      const auto& test = count > kHalf ? laboratory->unused : tested;
      for (std::size_t m = 0; m < kSplitMethods.size(); ++m) {
        // Fifty solves each; what differs between laboratories is a hundred times what differs between
        // splits.
        if (kSplitMethods[m] == kAlternating && split > 0) continue;
        SplitOutcome outcome;
        if (kSplitMethods[m] == kNoiseFloor) {
          outcome = judged(perfect, *laboratory, test);
        } else if (const auto solved = solve_as(kSplitMethods[m], train, model, laboratory->pivot_tip)) {
          outcome = judged(solved->value, *laboratory, test);
        }
        outcomes.tried[m][c].push_back(outcome);
      }
      if (count != kVariantCount || split > 0) continue;
      for (std::size_t v = 0; v < kVariants.size(); ++v) {
        const auto& [name, method, lengths, gains] = kVariants[v];
        SplitOutcome outcome;
        if (const auto solved = solve_as(method, train, model, laboratory->pivot_tip, {lengths, gains})) {
          outcome = judged(solved->value, *laboratory, test);
          outcome.residual_mm = mm_from_metres(mean_norm(calibration::arm_errors(solved->value, train)));
        }
        outcomes.variants[v].push_back(outcome);
      }
    }
  }
  return outcomes;
}

template <typename Pick>
Summary summary_over(const std::vector<SplitOutcome>& outcomes, const Pick& pick) {
  std::vector<double> values;
  values.reserve(outcomes.size());
  for (const auto& outcome : outcomes) values.push_back(pick(outcome));
  return summary_of(values);
}

template <typename Pick>
Curve split_curve(const SplitOutcomes& outcomes, std::size_t method, std::string figure, std::string label,
                  std::string y_name, const Pick& pick) {
  Curve curve{std::move(figure), std::move(label), "points", std::move(y_name), {}};
  for (std::size_t c = 0; c < kPointCounts.size(); ++c)
    curve.points.push_back(
        {static_cast<double>(kPointCounts[c]), summary_over(outcomes.tried[method][c], pick)});
  return curve;
}

void add_curves(StudyResult& study, const SplitOutcomes& outcomes) {
  for (std::size_t m = 0; m < kSplitMethods.size(); ++m) {
    const std::string method(kSplitMethods[m]);
    study.curves.push_back(split_curve(outcomes, m, "held-out error", method, "error_mm",
                                       [](const SplitOutcome& o) { return o.held_out_mm; }));
    if (kSplitMethods[m] == kNoiseFloor) continue;
    study.curves.push_back(split_curve(outcomes, m, "error to truth", method, "error_mm",
                                       [](const SplitOutcome& o) { return o.truth_mm; }));
    if (kSplitMethods[m] != kEq7 && kSplitMethods[m] != kJoint) continue;
    for (Eigen::Index j = 0; j < 3; ++j) {
      study.curves.push_back(split_curve(outcomes, m, "offset error",
                                         fmt::format("gamma{}, {}", j + 1, method), "error_deg",
                                         [j](const SplitOutcome& o) { return o.offset_error_deg[j]; }));
      study.curves.push_back(split_curve(outcomes, m, "gain error", fmt::format("k{}, {}", j + 1, method),
                                         "error", [j](const SplitOutcome& o) { return o.gain_error[j]; }));
    }
  }
}

void add_key_figures(StudyResult& study, const SplitOutcomes& outcomes) {
  study.values["paper"] = {{"before_mm", paper::kBefore_mm},
                           {"after_mm", paper::kAfter_mm},
                           {"enough_points", paper::kEnoughPoints},
                           {"source", "section 4.4.2, Figure 7"}};
  for (const char* figure : {"held-out error", "error to truth"}) {
    Json by_method;
    std::string line = fmt::format("{}, {} points:", figure, kHalf);
    for (const auto method : kSplitMethods) {
      if (method == kNoiseFloor && std::string_view(figure) != "held-out error") continue;
      const double value = mean_at(curve_named(study.curves, figure, method), kHalf);
      by_method[std::string(method)] = number_or_null(value);
      line += fmt::format("  {} {:.3f} mm", method, value);
    }
    study.values["at_70_points"][figure] = by_method;
    study.lines.push_back(line);
  }
  Json refused;
  for (std::size_t m = 0; m + 1 < kSplitMethods.size(); ++m) {
    Json by_count = Json::array();
    for (const auto& point : curve_named(study.curves, "error to truth", kSplitMethods[m]).points)
      by_count.push_back(
          {{"points", static_cast<int>(point.x)}, {"solved", point.y.runs}, {"refused", point.y.refused}});
    refused[std::string(kSplitMethods[m])] = by_count;
  }
  study.values["refused"] = refused;
  Json variants = Json::array();
  for (std::size_t v = 0; v < kVariants.size(); ++v) {
    const auto of = [&](const auto& pick) { return summary_over(outcomes.variants[v], pick); };
    Json row{{"what", kVariants[v].name},
             {"train_mean_mm", number_or_null(of([](const auto& o) { return o.residual_mm; }).mean)},
             {"error_to_truth_mm", number_or_null(of([](const auto& o) { return o.truth_mm; }).mean)}};
    for (Eigen::Index j = 0; j < 2 && kVariants[v].lengths == Lengths::free; ++j) {
      const auto error = of([j](const SplitOutcome& o) { return o.length_error_mm[j]; });
      row[fmt::format("l{}_error_mm", j + 1)] = {{"mean", number_or_null(error.mean)},
                                                 {"sd", number_or_null(error.sd)}};
    }
    variants.push_back(row);
  }
  study.values["variants"] = variants;
}

}  // namespace

Expected<void> add_splits(StudyResult& study, const StudyOptions& options) {
  const auto runs = static_cast<std::size_t>(options.runs);
  std::vector<Expected<SplitOutcomes>> slots((runs + kRunsPerLaboratory - 1) / kRunsPerLaboratory);
  repeat(slots.size(), options.repeats, [&](std::size_t i) {
    slots[i] = try_laboratory(options, i, std::min(kRunsPerLaboratory, runs - i * kRunsPerLaboratory));
  });
  SplitOutcomes all;
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  for (const auto& slot : slots) {
    if (!slot) return tl::unexpected(slot.error());
    for (std::size_t m = 0; m < kSplitMethods.size(); ++m)
      for (std::size_t c = 0; c < kPointCounts.size(); ++c) append(all.tried[m][c], slot->tried[m][c]);
    for (std::size_t v = 0; v < kVariants.size(); ++v) append(all.variants[v], slot->variants[v]);
  }
  study.values["laboratories"] = slots.size();
  add_curves(study, all);
  add_key_figures(study, all);
  return {};
}

}  // namespace palpate::evaluation::studies
