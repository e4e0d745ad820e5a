#include "palpate/haptics/force_limiter.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace palpate {
namespace {

constexpr double kPaid_n_s = 1e-13;  // rounding of a blow of 1e-3 N s and more

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

ForceLimiter::ForceLimiter(const ForceLimits& limits) : limits_(limits) {
  for (const double value : {limits.peak_n, limits.continuous_n, limits.continuous_s, limits.slew_n_s,
                             limits.fade_s, limits.max_tip_speed_m_s, limits.stale_s}) {
    if (!(value > 0.0)) throw std::invalid_argument("force limiter: every limit must be > 0");
  }
  if (!(limits.start_ramp_s >= 0.0) || !(limits.longest_debt_s >= 0.0)) {
    throw std::invalid_argument("force limiter: start ramp and longest debt must be >= 0");
  }
}

void ForceLimiter::rearm() { overspeed_ = false; }

bool ForceLimiter::settled() const { return owed_.norm() < kPaid_n_s && blow_.norm() == 0.0; }

// The next force of the blows: what is owed at once, but never so high that the descent at the slew limit
// would give away more than is owed and still to come.
Vector3 ForceLimiter::pay(const Vector3& to_come, double room, double step, double period) const {
  const Vector3 total = owed_ + to_come;
  const double sum = total.norm();
  Vector3 target = Vector3::Zero();
  if (sum >= kPaid_n_s) {
    const Vector3 along = total / sum;
    const double due = std::max(0.0, along.dot(owed_) / period);
    target = std::min({descent_from(sum / period, step), due, room}) * along;
  }
  return blow_ + clamped(target - blow_, step);
}

Vector3 ForceLimiter::tick(const AskedForce& asked, double elapsed, double period) {
  // What was really held since the last tick is what the hand has had.
  const Vector3 given = elapsed * blow_;
  delivered_ += given;
  owed_ -= given;
  const Vector3 held = sustained_ + blow_;
  const double forget = std::exp(-elapsed / limits_.continuous_s);
  mean_square_ = forget * mean_square_ + (1.0 - forget) * held.squaredNorm();

  Vector3 sustained = asked.sustained, blow = asked.blow, to_come = asked.blow_to_come;
  fault_ = ForceFault::none;
  if (!(asked.input_age_s <= limits_.stale_s)) fault_ = ForceFault::stale_input;
  if (!sustained.allFinite() || !blow.allFinite() || !to_come.allFinite() ||
      !std::isfinite(asked.tip_speed)) {
    fault_ = ForceFault::not_finite;
    sustained.setZero();
    blow.setZero();
    to_come.setZero();
  } else if (asked.tip_speed > limits_.max_tip_speed_m_s) {
    overspeed_ = true;
  }
  if (overspeed_) fault_ = ForceFault::overspeed;
  if (fault_ == ForceFault::none) {
    gain_ = limits_.start_ramp_s > 0.0 ? std::min(1.0, gain_ + period / limits_.start_ramp_s) : 1.0;
  } else {
    gain_ = std::max(0.0, gain_ - period / limits_.fade_s);
  }

  double peak = mean_square_ > limits_.continuous_n * limits_.continuous_n
                    ? std::min(limits_.continuous_n, limits_.peak_n)
                    : limits_.peak_n;
  owed_ += gain_ * period * blow;
  since_blow_ = asked.blow_active ? 0.0 : since_blow_ + period;
  if (fault_ != ForceFault::none) {
    peak *= gain_;
    owed_ *= gain_;
    to_come.setZero();
  }
  if (since_blow_ > limits_.longest_debt_s) owed_.setZero();

  const double step = limits_.slew_n_s * period;
  const Vector3 wanted = clamped(gain_ * sustained, peak);
  const Vector3 before = sustained_;
  sustained_ += clamped(wanted - sustained_, step);
  const double left = step - (sustained_ - before).norm();
  blow_ = pay(gain_ * to_come, std::max(0.0, peak - sustained_.norm()), std::max(left, 1e-3 * step), period);
  // Where both change at once their sum may still stand above the peak: the blow waits.
  if ((sustained_ + blow_).norm() > limits_.peak_n) {
    const double room = std::max(0.0, limits_.peak_n - sustained_.norm());
    blow_ = clamped(blow_, room);
  }
  const Vector3 out = sustained_ + blow_;
  limited_ = (out - asked.sustained - asked.blow).norm() > 1e-9 || fault_ != ForceFault::none;
  return out;
}

}  // namespace palpate
