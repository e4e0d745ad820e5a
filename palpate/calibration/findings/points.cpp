#include "palpate/calibration/findings/points.h"

#include <algorithm>
#include <set>

#include "palpate/core/text.h"
#include "palpate/device/repeats.h"

namespace palpate::calibration::findings {
namespace {

// A pair that repeats an earlier one is left out, with its label and its weight; returns how many were.
std::size_t drop_repeated(PointPairs& pairs) {
  PointPairs kept{.from = {}, .to = {}, .weights = {}, .labels = {}, .by_label = pairs.by_label};
  std::set<device::Reading> known;
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    if (!known.insert(device::Reading().add(pairs.from[i]).add(pairs.to[i])).second) continue;
    kept.from.push_back(pairs.from[i]);
    kept.to.push_back(pairs.to[i]);
    kept.labels.push_back(pairs.labels[i]);
    if (!pairs.weights.empty()) kept.weights.push_back(pairs.weights[i]);
  }
  const std::size_t repeats = pairs.from.size() - kept.from.size();
  pairs = std::move(kept);
  return repeats;
}

// What the fit says of single points and of the lists' sizes.
std::vector<std::string> warnings_of(const PointPairs& pairs, const Estimate<RigidTransform>& estimate,
                                     std::size_t repeats) {
  constexpr double kUnlike = 0.01, kSure = 5.0;  // of the size; standard deviations
  constexpr std::size_t kMostNamed = 5;
  std::vector<std::string> warnings;
  if (repeats > 0) warnings.push_back(device::repeats_warning(repeats));
  if (estimate.value.mirrored)
    warnings.push_back("a mirror image would fit better: one list may be left-handed or out of order");
  if (const auto stray = stray_points(estimate, pairs.weights); !stray.empty()) {
    std::vector<std::string> named;
    for (std::size_t k = 0; k < std::min(stray.size(), kMostNamed); ++k)
      named.push_back(fmt::format("'{}' by {:.3g} mm", excerpt(pairs.labels[stray[k]]),
                                  kMm * estimate.residuals[stray[k]].norm()));
    warnings.push_back(fmt::format("{} far off what suits the others: {}{}; measure again, or leave out",
                                   counted(stray.size(), "point") + (stray.size() == 1 ? " lies" : " lie"),
                                   fmt::join(named, ", "), stray.size() > kMostNamed ? ", ..." : ""));
  }
  const SizeRatio size = size_ratio(pairs.from, pairs.to, pairs.weights);
  if (std::abs(size.ratio - 1.0) > std::max(kUnlike, kSure * size.sd))
    warnings.push_back(
        fmt::format("the second list is {:.4f} +- {:.4f} times as large as the first, which no rotation "
                    "explains: do both measure in the same unit, and truly?",
                    size.ratio, size.sd));
  return warnings;
}

Json to_json(const PointPairs& pairs, const Estimate<RigidTransform>& estimate, std::size_t repeats,
             const std::string& stray) {
  const RigidTransform& fit = estimate.value;
  const auto std_all = standard_deviations(estimate.covariance);
  Eigen::VectorXd scales(6);
  scales << Vector3::Constant(kDegreesPerRadian), Vector3::Constant(kMm);
  Json json;
  json["rotation"] = json_rows(fit.rotation);
  json["rotation_qwxyz"] = json_quaternion(Quaternion(fit.rotation));
  json["translation_mm"] = json_list(fit.translation, kMm);
  json["fre_mean_mm"] = kMm * mean_norm(estimate.residuals);
  json["fre_rms_mm"] = kMm * std::sqrt(3.0) * rms_per_component(estimate.residuals);
  json["rms_mm"] = kMm * rms_per_component(estimate.residuals);
  json["points"] = pairs.from.size();
  json["paired_by"] = pairs.by_label ? "label" : "order";
  json["residuals_mm"] = Json::array();
  for (std::size_t i = 0; i < pairs.labels.size(); ++i)
    json["residuals_mm"].push_back(
        Json{{"label", pairs.labels[i]}, {"xyz", json_list(estimate.residuals[i], kMm)}});
  json["condition"] = estimate.condition;
  json["std"] = Json{{"rotation_deg", json_list(std_all.head<3>(), kDegreesPerRadian)},
                     {"translation_mm", json_list(std_all.tail<3>(), kMm)}};
  json["covariance"] = json_covariance({"rotation_x_deg", "rotation_y_deg", "rotation_z_deg",
                                        "translation_x_mm", "translation_y_mm", "translation_z_mm"},
                                       estimate.covariance, scales);
  json["warnings"] = warnings_of(pairs, estimate, repeats);
  if (!stray.empty()) json["warnings"].push_back(stray);
  return json;
}

}  // namespace

Expected<PointFindings> find_rigid_motion(PointPairs pairs) {
  const std::size_t repeats = drop_repeated(pairs);
  auto estimate = absolute_orientation(pairs.from, pairs.to, pairs.weights);
  std::string stray;
  if (const auto odd = misplaced_point(pairs.from, pairs.to, pairs.weights))
    stray = fmt::format(
        "without point '{}' the others fit more than five times better: measure it again, or look "
        "whether it is paired rightly",
        excerpt(pairs.labels[*odd]));
  if (!estimate)
    return tl::unexpected(
        Error{estimate.error().kind, estimate.error().message + (stray.empty() ? "" : "; " + stray)});
  Json json = to_json(pairs, *estimate, repeats, stray);
  return PointFindings{std::move(*estimate), std::move(json)};
}

}  // namespace palpate::calibration::findings
