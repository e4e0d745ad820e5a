#include "palpate/haptics/force_shaper.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr double kPaid_n_s = 1e-13;     // rounding of a blow of 1e-3 N s and more
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

bool ForceShaper::settled() const { return owed_.norm() < kPaid_n_s && blow_.norm() == 0.0; }

void ForceShaper::lose(const Vector3& impulse) {
  lost_ += impulse;
  owed_ -= impulse;
}

// The force the blows want next: what is owed at once, but never so high that the descent at the slew limit
// would give away more than is owed and still to come. Where the slew limit has room for all of that within a
// tick it comes as it is, a course that ends pulling (the paper's) included.
Vector3 ForceShaper::payment(const Vector3& to_come, double step, double period) const {
  if (owed_.norm() < kPaid_n_s) return Vector3::Zero();
  if (owed_.norm() + to_come.norm() <= step * period) return owed_ / period;
  const Vector3 total = owed_ + to_come;
  const double sum = total.norm();
  if (sum < kPaid_n_s) return Vector3::Zero();
  const Vector3 along = total / sum;
  const double due = std::max(0.0, along.dot(owed_) / period);
  return std::min(descent_from(sum / period, step), due) * along;
}

Vector3 ForceShaper::tick(const AskedForce& asked, const ForceRoom& room, double elapsed, double period) {
  // What was really held since the last tick is what the hand has had.
  const Vector3 given = elapsed * blow_;
  delivered_ += given;
  owed_ += period * asked.blow - given;
  lose((1.0 - room.gain) * period * asked.blow);
  // After a fault, or a force held too long, the blow ends on the shortest way; nothing is pulled back for
  // it.
  if (room.fading || room.forgive) {
    writing_off_ = true;
  } else if (blow_.norm() == 0.0) {
    writing_off_ = false;
  }
  since_blow_ = asked.blow_active ? 0.0 : since_blow_ + period;
  if (writing_off_ || since_blow_ > longest_debt_s_) lose(owed_);

  const double peak = room.fading ? room.gain * room.peak : room.peak;
  const double step = std::max(room.step, kLeastStep_n);
  const Vector3 before = held();
  const Vector3 pushed = room.gain * asked.sustained;
  sustained_ += clamped(clamped(pushed, peak) - sustained_, step);
  const Vector3 to_come = writing_off_ ? Vector3::Zero() : Vector3(room.gain * asked.blow_to_come);
  const Vector3 due = sustained_ + payment(to_come, step, period), wanted = clamped(due, peak);
  at_peak_ = due.norm() > peak || pushed.norm() > peak;
  blow_ = before + clamped(wanted - before, step) - sustained_;
  if (blow_.norm() < kNothing_n) blow_.setZero();
  const Vector3 out = held();
  limited_ = (out - asked.sustained - asked.blow).norm() > 1e-9 || room.fading;
  return out;
}

}  // namespace palpate
