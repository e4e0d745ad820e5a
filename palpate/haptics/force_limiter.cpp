#include "palpate/haptics/force_limiter.h"

#include <algorithm>
#include <cmath>

namespace palpate::haptics {
namespace {

constexpr double kSettled_n_s = 1e-13;  // rounding of an impact of 1e-3 N s and more
constexpr double kNothing_n = 1e-12;    // rounding of forces
constexpr double kLeastStep_n = 1e-12;  // a smaller change is none

Vector3 clamped(const Vector3& v, double most) {
  const double n = v.norm();
  return n > most ? Vector3(most / n * v) : v;
}

// Largest force f from which a descent by `step` per tick gives away no more than `sum`: f + (f - step) + ...
// <= sum.
double descent_from(double sum, double step) {
  if (!(sum > 0.0)) return 0.0;
  const double n = std::max(1.0, std::ceil(0.5 * (std::sqrt(1.0 + 8.0 * sum / step) - 1.0)));
  return sum / n + 0.5 * step * (n - 1.0);
}

}  // namespace

bool ForceLimiter::settled() const { return backlog_.norm() < kSettled_n_s && impact_.norm() == 0.0; }

void ForceLimiter::drop(const Vector3& impulse) {
  lost_ += impulse;
  backlog_ -= impulse;
}

// The force the impacts want next: the backlog at once, but never so high that the descent at the slew limit
// would give away more than the backlog and what is still to come. Where the slew limit has room for all of
// that within a tick it comes as it is, a course that ends pulling (the paper's) included.
Vector3 ForceLimiter::catch_up(const Vector3& to_come, double step, double period) const {
  if (backlog_.norm() < kSettled_n_s) return Vector3::Zero();
  if (backlog_.norm() + to_come.norm() <= step * period) return backlog_ / period;
  const Vector3 total = backlog_ + to_come;
  const double sum = total.norm();
  if (sum < kSettled_n_s) return Vector3::Zero();
  const Vector3 along = total / sum;
  const double due = std::max(0.0, along.dot(backlog_) / period);
  return std::min(descent_from(sum / period, step), due) * along;
}

Vector3 ForceLimiter::tick(const RequestedForce& requested, const AvailableForce& available, double elapsed,
                           double period) {
  // What was really held since the last tick is what the hand has had.
  const Vector3 given = elapsed * impact_;
  delivered_ += given;
  backlog_ += period * requested.impact - given;
  drop((1.0 - available.gain) * period * requested.impact);
  // After a fault, or a force held too long, the impact ends on the shortest way; nothing is pulled back for
  // it.
  if (available.fading || available.drop_backlog) {
    writing_off_ = true;
  } else if (impact_.norm() == 0.0) {
    writing_off_ = false;
  }
  since_impact_ = requested.impact_active ? 0.0 : since_impact_ + period;
  if (writing_off_ || since_impact_ > max_backlog_s_) drop(backlog_);

  const double peak = available.fading ? available.gain * available.peak : available.peak;
  const double step = std::max(available.step, kLeastStep_n);
  const Vector3 before = held();
  const Vector3 pushed = available.gain * requested.continuous;
  continuous_ += clamped(clamped(pushed, std::min(peak, available.most_continuous)) - continuous_, step);
  const Vector3 to_come = writing_off_ ? Vector3::Zero() : Vector3(available.gain * requested.impact_to_come);
  const Vector3 due = continuous_ + catch_up(to_come, step, period), wanted = clamped(due, peak);
  at_peak_ = due.norm() > peak || pushed.norm() > peak;
  impact_ = before + clamped(wanted - before, step) - continuous_;
  if (impact_.norm() < kNothing_n) impact_.setZero();
  const Vector3 out = held();
  limited_ = (out - requested.continuous - requested.impact).norm() > 1e-9 || available.fading;
  return out;
}

}  // namespace palpate::haptics
