#include "palpate/calibration/arm_validation.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "palpate/calibration/arm_motion.h"
#include "palpate/core/random.h"
#include "palpate/core/statistics.h"

namespace palpate::calibration {
namespace {

constexpr double kWorthFreeing = 0.99;

// Halves the samples' indices across the longest side until there are `parts` parts.
void halve(const std::vector<Vector3>& places, std::vector<std::size_t> indices, int parts,
           std::vector<std::vector<std::size_t>>& out) {
  if (parts <= 1) {
    out.push_back(std::move(indices));
    return;
  }
  Vector3 low = places[indices[0]], high = low;
  for (std::size_t i : indices) {
    low = low.cwiseMin(places[i]);
    high = high.cwiseMax(places[i]);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  std::stable_sort(indices.begin(), indices.end(),
                   [&](std::size_t a, std::size_t b) { return places[a][axis] < places[b][axis]; });
  const auto middle = indices.begin() + static_cast<std::ptrdiff_t>(indices.size() / 2);
  halve(places, {indices.begin(), middle}, parts / 2, out);
  halve(places, {middle, indices.end()}, parts - parts / 2, out);
}

Expected<HeldOut> hold_out(const std::vector<device::ArmObservation>& samples, const device::ArmModel& model,
                           ArmOptions options, const std::vector<std::vector<std::size_t>>& parts) {
  options.allow_field = false;  // no covariance is looked at
  if (options.free.delay && !options.delay_start) {
    const auto all = calibrate_arm(samples, model, options);
    if (!all) return tl::unexpected(all.error());
    options.delay_start = all->value.delay_s;
  }
  HeldOut held;
  for (const auto& part : parts) {
    if (part.empty()) continue;
    std::vector<bool> used(samples.size(), true);
    for (const std::size_t i : part) used[i] = false;
    const auto estimate = calibrate_arm(samples, model, options, used);
    if (!estimate) return tl::unexpected(estimate.error());
    std::vector<Vector3> errors;
    for (const std::size_t i : part) errors.push_back(estimate->residuals[i]);
    held.means.push_back(mean_norm(errors));
    held.errors.insert(held.errors.end(), errors.begin(), errors.end());
    held.samples.insert(held.samples.end(), part.begin(), part.end());
  }
  held.mean = mean_norm(held.errors);
  return held;
}

struct Term {
  const char* name;
  bool ArmFree::*on;
};
constexpr Term kTerms[]{{"gains", &ArmFree::gains},          {"offsets", &ArmFree::offsets},
                        {"lengths", &ArmFree::lengths},      {"tip", &ArmFree::tip},
                        {"quadratic", &ArmFree::quadratic},  {"hysteresis", &ArmFree::hysteresis},
                        {"delay", &ArmFree::delay},          {"dh", &ArmFree::dh},
                        {"correction", &ArmFree::correction}};

// Whether an arm of this kind has what the term frees.
bool has_term(const device::ArmModel& model, bool ArmFree::*term) {
  const bool of_every_arm = term == &ArmFree::tip || term == &ArmFree::delay;
  const bool cartesian = model.kind == device::ArmModel::Kind::cartesian;
  return of_every_arm || cartesian == (term == &ArmFree::correction);
}

}  // namespace

Expected<HeldOut> held_out_by_region(const std::vector<device::ArmObservation>& samples,
                                     const device::ArmModel& model, const ArmOptions& options, int regions) {
  const auto first = uncorrected_arm(samples, model, options);
  if (!first) return tl::unexpected(first.error());
  std::vector<Vector3> places;
  for (const auto& sample : samples) places.push_back(measured_tip(first->value, sample).m);
  std::vector<std::size_t> all(samples.size());
  std::iota(all.begin(), all.end(), 0u);
  std::vector<std::vector<std::size_t>> parts;
  halve(places, all, regions, parts);
  return hold_out(samples, model, options, parts);
}

Expected<HeldOut> held_out_by_folds(const std::vector<device::ArmObservation>& samples,
                                    const device::ArmModel& model, const ArmOptions& options,
                                    std::uint64_t seed, int folds) {
  std::vector<std::size_t> order(samples.size());
  std::iota(order.begin(), order.end(), 0u);
  // In an order of the readings' own: the folds are the same however the rows stand.
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto &u = samples[a].joints, &v = samples[b].joints;
    return std::lexicographical_compare(u.begin(), u.end(), v.begin(), v.end());
  });
  Random random(seed, "calibrate arm/folds");
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  std::vector<std::vector<std::size_t>> parts(static_cast<std::size_t>(folds));
  for (std::size_t i = 0; i < order.size(); ++i) parts[i % parts.size()].push_back(order[i]);
  return hold_out(samples, model, options, parts);
}

ArmMisfit arm_misfit(const ArmSolution& arm, const std::vector<device::ArmObservation>& samples) {
  std::array<std::vector<double>, 3> places;
  for (const auto& sample : samples)
    for (std::size_t i = 0; i < 3; ++i)
      places[i].push_back(measured_tip(arm, sample).m[static_cast<Eigen::Index>(i)]);
  const Vector3 centre(median(places[0]), median(places[1]), median(places[2]));
  std::vector<double> errors, distances;
  for (const auto& error : arm_errors(arm, samples)) errors.push_back(error.norm());
  for (const auto& sample : samples) distances.push_back((measured_tip(arm, sample).m - centre).norm());
  return {median(errors), median(distances)};
}

std::string free_text(const ArmFree& free, const device::ArmModel& model) {
  std::string text;
  for (const auto& term : kTerms)
    if (free.*term.on && has_term(model, term.on)) text += (text.empty() ? "" : ",") + std::string(term.name);
  return text;
}

Expected<ArmChoice> choose_free(const std::vector<device::ArmObservation>& samples,
                                const device::ArmModel& model, const ArmOptions& options) {
  const bool dh = model.kind == device::ArmModel::Kind::dh;
  std::vector<Term> candidates;
  if (taken_in_motion(samples)) candidates.push_back({"delay", &ArmFree::delay});
  const auto add = [&](const Term& term) {
    if (has_term(model, term.on)) candidates.push_back(term);
  };
  add(dh ? Term{"dh", &ArmFree::dh} : Term{"lengths", &ArmFree::lengths});
  add({"correction", &ArmFree::correction});
  add({"quadratic", &ArmFree::quadratic});
  if (all_have_times(samples)) add({"hysteresis", &ArmFree::hysteresis});

  ArmChoice choice;
  choice.free = {
      .gains = true, .offsets = true, .lengths = false, .tip = options.free.tip, .correction = false};
  ArmOptions how = options;
  how.free = choice.free;
  auto best = held_out_by_region(samples, model, how);
  if (!best) return tl::unexpected(best.error());
  choice.tried.emplace_back(free_text(choice.free, model), best->mean);
  choice.why =
      fmt::format("{} {:.4f} mm in regions not seen", free_text(choice.free, model), 1e3 * best->mean);
  while (!candidates.empty()) {
    std::size_t winner = candidates.size();
    HeldOut won = *best;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      how.free = choice.free;
      how.free.*candidates[k].on = true;
      const auto held = held_out_by_region(samples, model, how);
      if (!held) continue;  // too few samples for so many unknowns
      choice.tried.emplace_back(free_text(how.free, model), held->mean);
      std::size_t better = 0;
      for (std::size_t i = 0; i < held->means.size(); ++i) better += held->means[i] < best->means[i];
      if (held->mean < std::min(kWorthFreeing * best->mean, won.mean) && 2 * better > held->means.size()) {
        winner = k;
        won = *held;
      }
    }
    if (winner == candidates.size()) break;
    choice.free.*candidates[winner].on = true;
    choice.why += fmt::format("; {} lowers it to {:.4f} mm", candidates[winner].name, 1e3 * won.mean);
    candidates.erase(candidates.begin() + static_cast<std::ptrdiff_t>(winner));
    *best = std::move(won);
  }
  std::string left;
  for (const auto& candidate : candidates) left += (left.empty() ? "" : ", ") + std::string(candidate.name);
  if (!left.empty()) choice.why += fmt::format("; {}: not better by 1 %, or not in most regions", left);
  return choice;
}

}  // namespace palpate::calibration
