#include "palpate/physics/velocity_jump.h"

#include <algorithm>
#include <cmath>

#include "palpate/math/linear_algebra.h"

namespace palpate::physics {
namespace {

struct Straight {
  Vector3 place = Vector3::Zero(), velocity = Vector3::Zero();
  double velocity_variance = 0.0;  // per component
};

// Parabola under gravity through a few observations: place and velocity at `t`.
Straight parabola_at(const Vector3& gravity, std::span<const SeenBall> seen, double t) {
  double n = 0, st = 0, stt = 0;
  Vector3 sp = Vector3::Zero(), stp = Vector3::Zero();
  for (const auto& ball : seen) {
    const double s = ball.time - t;
    const Vector3 p = ball.position - 0.5 * s * s * gravity;
    n += 1;
    st += s;
    stt += s * s;
    sp += p;
    stp += s * p;
  }
  const double det = n * stt - st * st;
  Straight line{(stt * sp - st * stp) / det, (n * stp - st * sp) / det, 0.0};
  double scatter = 0.0;
  for (const auto& ball : seen) {
    const double s = ball.time - t;
    scatter += (ball.position - 0.5 * s * s * gravity - line.place - s * line.velocity).squaredNorm();
  }
  line.velocity_variance = scatter / (3.0 * (n - 2.0)) * n / det;
  return line;
}

// Observations first ... last-1 that lie within `length` of `seen[at]`, `at` included.
std::span<const SeenBall> up_to(std::span<const SeenBall> seen, std::size_t at, double length,
                                std::size_t first) {
  std::size_t from = at;
  while (from > first && seen[at].time - seen[from - 1].time <= length) --from;
  return seen.subspan(from, at + 1 - from);
}

std::span<const SeenBall> onwards(std::span<const SeenBall> seen, std::size_t at, double length,
                                  std::size_t end) {
  std::size_t to = at + 1;
  while (to < end && seen[to].time - seen[at].time <= length) ++to;
  return seen.subspan(at, to - at);
}

// A flight of some tenths of a second with an acceleration of its own: what air, and a spin nobody knows of,
// do to a ball is seen, not assumed. p = c0 + c1 s + c2 s^2, s = time - origin.
struct Bend {
  double origin = 0.0;
  Eigen::Matrix3d c;  // rows c0, c1, c2
  Vector3 place(double t) const {
    const double s = t - origin;
    return (c.row(0) + s * c.row(1) + s * s * c.row(2)).transpose();
  }
  Vector3 velocity(double t) const { return (c.row(1) + 2.0 * (t - origin) * c.row(2)).transpose(); }
};

Bend bend_through(std::span<const SeenBall> seen, double origin) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero(), B = Eigen::Matrix3d::Zero();
  const double unit = std::max(std::abs(seen.front().time - origin), std::abs(seen.back().time - origin));
  for (const auto& ball : seen) {
    const double s = (ball.time - origin) / unit;
    const Vector3 powers(1.0, s, s * s);
    A += powers * powers.transpose();
    B += powers * ball.position.transpose();
  }
  Bend bend{origin, solve_symmetric_columns(A, B)};
  bend.c.row(1) /= unit;
  bend.c.row(2) /= unit * unit;
  return bend;
}

// Where two flights come closest, near `t`.
VelocityJump meeting(const Bend& came, const Bend& went, double t, double room) {
  const double low = t - room, high = t + room;
  for (int k = 0; k < 5; ++k) {
    const Vector3 apart = went.place(t) - came.place(t), parting = went.velocity(t) - came.velocity(t);
    t = std::clamp(t - apart.dot(parting) / std::max(parting.squaredNorm(), 1e-12), low, high);
  }
  return {t,   0.5 * (came.place(t) + went.place(t)), came.velocity(t), went.velocity(t),
          0.0, (went.place(t) - came.place(t)).norm()};
}

}  // namespace

std::vector<VelocityJump> find_velocity_jumps(const Vector3& gravity, std::span<const SeenBall> seen,
                                              const JumpSettings& settings) {
  // A jump lies between seen[i] and seen[i + 1].
  std::vector<double> change(seen.size(), 0.0);
  for (std::size_t i = 0; i + 1 < seen.size(); ++i) {
    const auto before = up_to(seen, i, settings.first_look_s, 0);
    const auto after = onwards(seen, i + 1, settings.first_look_s, seen.size());
    const double between = seen[i + 1].time - seen[i].time;
    if (std::min(before.size(), after.size()) < settings.least_seen || between > settings.first_look_s)
      continue;
    const double middle = 0.5 * (seen[i].time + seen[i + 1].time);
    const auto came = parabola_at(gravity, before, middle), went = parabola_at(gravity, after, middle);
    const double sd = std::sqrt(came.velocity_variance + went.velocity_variance);
    const double jumped = (went.velocity - came.velocity).norm();
    if (jumped > settings.least_deviations * sd) change[i] = jumped;
  }
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i + 1 < seen.size(); ++i) {
    if (!(change[i] > settings.least_change)) continue;
    bool largest = true;  // of equals the first
    for (std::size_t k = 0; k + 1 < seen.size() && largest; ++k)
      if (std::abs(seen[k].time - seen[i].time) <= settings.first_look_s)
        largest = change[k] < change[i] || (change[k] == change[i] && k >= i);
    if (largest) found.push_back(i);
  }

  std::vector<VelocityJump> jumps;
  for (std::size_t f = 0; f < found.size(); ++f) {
    const std::size_t i = found[f], first = f > 0 ? found[f - 1] + 1 : 0,
                      end = f + 1 < found.size() ? found[f + 1] + 1 : seen.size();
    const auto left = up_to(seen, i, settings.fit_s, first);
    const auto right = onwards(seen, i + 1, settings.fit_s, end);
    if (std::min(left.size(), right.size()) < settings.least_seen) continue;
    const double middle = 0.5 * (seen[i].time + seen[i + 1].time);
    const double room = 0.010 + (seen[i + 1].time - seen[i].time);
    VelocityJump jump = meeting(bend_through(left, middle), bend_through(right, middle), middle, room);
    jump.seen_s = std::min(left.back().time - left.front().time, right.back().time - right.front().time);
    if (jump.change().norm() > settings.least_change) jumps.push_back(jump);
  }
  return jumps;
}

bool bounced_on_resting_surface(const VelocityJump& jump, const Vector3& up, double mu) {
  const double came = -up.dot(jump.before), went = up.dot(jump.after);
  if (!(came > 0.0) || !(went > 0.0) || went > came) return false;
  const Vector3 change = jump.change();
  const double along = up.dot(change);
  return (change - along * up).norm() <= mu * along;
}

double restitution_of(const VelocityJump& jump, const Vector3& up) {
  return -up.dot(jump.after) / up.dot(jump.before);
}

}  // namespace palpate::physics
