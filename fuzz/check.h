// The promises every target checks. A broken one prints what it is and aborts, which the fuzzer reports with
// the file.
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "fuzz/targets.h"
#include "palpate/core/expected.h"
#include "palpate/math/estimate.h"
#include "palpate/math/pose.h"

namespace palpate::fuzz {

// Recordings are cut to this many rows before they reach a solver, so that one execution stays short.
inline constexpr std::size_t kMostRows = 40;

template <typename T>
void cut(std::vector<T>& rows, std::size_t most = kMostRows) {
  if (rows.size() > most) rows.erase(rows.begin() + static_cast<std::ptrdiff_t>(most), rows.end());
}

void hold(bool promise, std::string_view what);
// One line of text a terminal shows as it is, of a length a person reads.
void hold_one_line(const Error& error);

template <typename Derived>
void hold_finite(const Eigen::MatrixBase<Derived>& numbers, std::string_view what) {
  hold(numbers.allFinite(), what);
}
inline void hold_finite(double number, std::string_view what) { hold(std::isfinite(number), what); }
template <typename A, typename B>
void hold_finite(const Pose<A, B>& pose, std::string_view what) {
  hold(pose.translation.allFinite() && std::abs(pose.rotation.norm() - 1.0) < 1e-6, what);
}

// True where there is a value; else its error is held to the promise and kept.
template <typename T>
bool answered(const Expected<T>& result, Refusals& refusals) {
  if (result) return true;
  hold_one_line(result.error());
  refusals.push_back(result.error().message);
  return false;
}

// The same for a calibration, whose covariance and residuals must be finite and whose variances not negative.
template <typename T>
bool answered(const Expected<Estimate<T>>& result, Refusals& refusals) {
  if (!answered<Estimate<T>>(result, refusals)) return false;
  const Estimate<T>& estimate = *result;
  hold_finite(estimate.covariance, "a calibration's covariance is finite");
  hold(estimate.covariance.size() == 0 || estimate.covariance.diagonal().minCoeff() >= 0.0,
       "a calibration's variances are not negative");
  for (const auto& residual : estimate.residuals)
    hold_finite(residual, "a calibration's residuals are finite");
  hold(!std::isnan(estimate.condition), "a calibration's condition is a number");
  return true;
}

}  // namespace palpate::fuzz
