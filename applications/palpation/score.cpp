#include "applications/palpation/score.h"

#include <algorithm>
#include <cmath>

namespace palpate::applications::palpation {

double Score::median_error() const {
  std::array<double, kMostNodules> known{};
  std::size_t count = 0;
  for (const double e : error)
    if (std::isfinite(e) && count < static_cast<std::size_t>(found)) known[count++] = e;
  if (count == 0) return std::numeric_limits<double>::quiet_NaN();
  std::sort(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(count));
  return 0.5 * (known[(count - 1) / 2] + known[count / 2]);
}

Score score_of(std::span<const HiddenNodule> nodules, std::span<const Vector3> marks, double within) {
  nodules = nodules.first(std::min(nodules.size(), kMostNodules));
  marks = marks.first(std::min(marks.size(), kMostMarks));
  Score score;
  score.nodules = static_cast<int>(nodules.size());
  score.error.fill(std::numeric_limits<double>::quiet_NaN());
  std::array<bool, kMostMarks> used{};
  for (;;) {
    double nearest = within;
    std::size_t nodule = nodules.size(), mark = marks.size();
    for (std::size_t i = 0; i < nodules.size(); ++i)
      for (std::size_t k = 0; k < marks.size() && !std::isfinite(score.error[i]); ++k) {
        const double distance = (marks[k] - nodules[i].above).norm();
        if (used[k] || !(distance <= nearest)) continue;
        nearest = distance;
        nodule = i;
        mark = k;
      }
    if (nodule == nodules.size()) break;
    score.error[nodule] = nearest;
    used[mark] = true;
    ++score.found;
  }
  score.false_alarms = static_cast<int>(marks.size()) - score.found;
  return score;
}

}  // namespace palpate::applications::palpation
