#include "palpate/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace palpate::inline core {

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double quantile(std::vector<double> values, double q) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double place = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const auto above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

double ErrorSummary::rms() const {
  double sum = 0.0;
  for (double e : errors_) sum += e * e;
  return errors_.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(errors_.size()));
}

double ErrorSummary::mean() const {
  double sum = 0.0;
  for (double e : errors_) sum += e;
  return errors_.empty() ? 0.0 : sum / static_cast<double>(errors_.size());
}

double ErrorSummary::maximum() const {
  return errors_.empty() ? 0.0 : *std::max_element(errors_.begin(), errors_.end());
}

double ErrorSummary::quantile(double share) const {
  if (errors_.empty()) return 0.0;
  auto sorted = errors_;
  std::sort(sorted.begin(), sorted.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

}  // namespace palpate::inline core
