#include "palpate/core/error_summary.h"

#include <algorithm>
#include <cmath>

namespace palpate::inline core {

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
