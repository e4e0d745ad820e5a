#include "palpate/calibration/findings/landmarks.h"

#include <algorithm>
#include <set>

#include "palpate/core/text.h"
#include "palpate/device/repeats.h"

namespace palpate::calibration::findings {
namespace {

Json to_json(const Estimate<TouchedLandmarks>& estimate, std::size_t repeats) {
  const TouchedLandmarks& found = estimate.value;
  const auto sd = standard_deviations(estimate.covariance);
  Json json;
  json["landmarks"] = Json::array();
  json["warnings"] = Json::array();
  Json all = Json::array();
  std::vector<std::string> names;
  for (std::size_t k = 0; k < found.landmarks.size(); ++k) {
    const auto& landmark = found.landmarks[k];
    const Vector3 std_k = sd.segment<3>(3 * static_cast<Eigen::Index>(k));
    all.push_back(json_list(std_k, kMm));
    json["landmarks"].push_back({{"label", found.labels[k]},
                                 {"place_mm", json_list(landmark.place.m, kMm)},
                                 {"std_mm", json_list(std_k, kMm)},
                                 {"normal", json_list(landmark.normal)},
                                 {"surface", found.surface[k]},
                                 {"off_surface_mm", kMm * found.distance[k]},
                                 {"touches", found.touches[k]}});
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("{}_{}_mm", found.labels[k], axis));
    if (found.distance[k] > kOffSurface)
      json["warnings"].push_back(
          fmt::format("landmark '{}' lies {:.1f} mm off the nearest surface ({}): its normal is only a guess",
                      excerpt(found.labels[k]), kMm * found.distance[k], found.surface[k]));
  }
  json["touch_sd_mm"] = kMm * found.touch.sd;
  json["touch_freedoms"] = found.touch.freedoms;
  json["rms_mm"] = kMm * rms_per_component(estimate.residuals);
  json["std"] = {{"place_mm", all}};
  json["covariance"] = json_covariance(names, estimate.covariance, Eigen::VectorXd::Constant(sd.size(), kMm));
  if (repeats > 0) json["warnings"].push_back(device::repeats_warning(repeats));
  return json;
}

}  // namespace

Expected<LandmarkFindings> find_landmarks(std::vector<LandmarkTouch> touches,
                                          const std::vector<rig::SurfaceCalibration>& surfaces,
                                          const LandmarkTouchOptions& options) {
  std::set<std::pair<std::string, device::Reading>> known;
  const std::size_t repeats = std::erase_if(touches, [&](const LandmarkTouch& touch) {
    return !known.insert({touch.label, device::Reading().add(touch.place)}).second;
  });
  auto estimate = landmarks_from_touches(touches, surfaces, options);
  if (!estimate) return tl::unexpected(estimate.error());
  // A dot or two beside the surfaces may be on a box. Where most are, the surface that they are on is missing.
  const auto& off = estimate->value.distance;
  const auto beside = std::count_if(off.begin(), off.end(), [](double d) { return d > kOffSurface; });
  if (2 * beside > static_cast<std::ptrdiff_t>(off.size()))
    return refused(
        "{} of {} landmarks lie more than {:.0f} mm off every surface, up to {:.0f} mm; first calibrate the "
        "surface that they are on (palpate calibrate surface), or check frame and unit of the points",
        beside, off.size(), kMm * kOffSurface, kMm * *std::max_element(off.begin(), off.end()));
  Json json = to_json(*estimate, repeats);
  return LandmarkFindings{std::move(*estimate), std::move(json)};
}

}  // namespace palpate::calibration::findings
