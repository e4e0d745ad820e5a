// Two lists of points into the absolute orientation.
#include <cmath>

#include "fuzz/check.h"
#include "fuzz/split.h"
#include "palpate/calibration/absolute_orientation.h"
#include "palpate/device/point_file.h"

namespace palpate::fuzz {

Refusals points(std::string_view file) {
  Refusals refusals;
  const auto [first, second] = split_files(file);
  auto from = device::parse_points(first, "from.csv");
  auto to = device::parse_points(second, "to.csv");
  if (!answered(from, refusals) || !answered(to, refusals)) return refusals;
  for (const auto& list : {*from, *to})
    for (const auto& point : list.points) hold_finite(point, "points read are finite");
  const auto count = std::min({from->points.size(), to->points.size(), kMostRows});
  for (auto* list : {&*from, &*to}) {
    cut(list->points, count);
    cut(list->weights, count);
  }
  for (const auto& weights : {std::vector<double>(), to->weights}) {
    const auto stray = calibration::misplaced_point(from->points, to->points, weights);
    hold(!stray || *stray < from->points.size(), "a misplaced point is one of the points");
    const auto fit = calibration::absolute_orientation(from->points, to->points, weights);
    if (!answered(fit, refusals)) continue;
    hold_finite(fit->value.rotation, "a rotation is finite");
    hold_finite(fit->value.translation, "a translation is finite");
    for (const auto i : calibration::stray_points(*fit, weights))
      hold(i < from->points.size(), "a stray point is one of the points");
    const calibration::SizeRatio size = calibration::size_ratio(from->points, to->points, weights);
    hold(std::isfinite(size.ratio) && std::isfinite(size.sd), "a ratio of sizes is finite");
  }
  return refusals;
}

}  // namespace palpate::fuzz
