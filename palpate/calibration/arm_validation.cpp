#include "palpate/calibration/arm_validation.h"

#include <algorithm>
#include <numeric>

namespace palpate {
namespace {

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

}  // namespace

Expected<std::vector<double>> held_out_by_region(const std::vector<ArmObservation>& samples,
                                                 const ArmModel& model, const ArmOptions& options,
                                                 int regions) {
  const auto first = uncorrected_arm(samples, model, options);
  if (!first) return tl::unexpected(first.error());
  std::vector<Vector3> places;
  for (const auto& sample : samples) places.push_back(measured_tip(first->value, sample).m);
  std::vector<std::size_t> all(samples.size());
  std::iota(all.begin(), all.end(), 0u);
  std::vector<std::vector<std::size_t>> parts;
  halve(places, all, regions, parts);
  std::vector<double> means;
  for (const auto& part : parts) {
    std::vector<ArmObservation> training, test;
    for (std::size_t i = 0; i < samples.size(); ++i)
      (std::find(part.begin(), part.end(), i) == part.end() ? training : test).push_back(samples[i]);
    if (test.empty()) continue;
    const auto estimate = calibrate_arm(training, model, options);
    if (!estimate) return tl::unexpected(estimate.error());
    means.push_back(mean_norm(arm_errors(estimate->value, test)));
  }
  return means;
}

}  // namespace palpate
