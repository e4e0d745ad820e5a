#include "palpate/physics/balls.h"

#include <algorithm>
#include <cmath>

namespace palpate::physics {

std::optional<double> first_touch(const BallModel& model, const BallState& a, const BallState& b, double h) {
  const double reach = 2.0 * model.radius;
  const Vector3 from = b.position - a.position;
  const Vector3 to = fly(model, b, h).position - fly(model, a, h).position;
  if (from.norm() <= reach) {
    if (from.dot(b.velocity - a.velocity) < 0.0) return 0.0;
    return std::nullopt;
  }
  // |from + s (to - from)| = reach on the chord ...
  const Vector3 way = to - from;
  const double A = way.squaredNorm(), B = from.dot(way), C = from.squaredNorm() - reach * reach;
  const double root = B * B - A * C;
  if (B >= 0.0 || root < 0.0) return std::nullopt;
  double s = h * C / (-B + std::sqrt(root));  // the smaller solution, without cancellation
  if (s > h) return std::nullopt;
  // ... and sharpened on the flights themselves.
  for (int i = 0; i < 3; ++i) {
    const BallState x = fly(model, a, s), y = fly(model, b, s);
    const Vector3 apart = y.position - x.position;
    const double closing = apart.dot(y.velocity - x.velocity) / apart.norm();
    if (closing >= 0.0) break;
    s = std::clamp(s - (apart.norm() - reach) / closing, 0.0, h);
  }
  return s;
}

void collide(const BallModel& model, const Bounce& law, BallState& a, BallState& b) {
  const Vector3 n = (b.position - a.position).normalized();
  const Vector3 relative = b.velocity - a.velocity;
  const double approach = -n.dot(relative);
  if (!(approach > 0.0)) return;
  // Equal masses: each takes half of every change of the relative velocity.
  Vector3 change = (1.0 + law.restitution) * approach * n;
  // Velocity of b's surface beside a's where they touch.
  const Vector3 slip = relative + approach * n - model.radius * (a.spin + b.spin).cross(n);
  if (const double speed = slip.norm(); law.friction > 0.0 && speed > 0.0) {
    const double grip = std::min(0.4, law.friction * (1.0 + law.restitution) * approach / speed);
    const Vector3 rubbed = -grip * slip;
    change += rubbed;
    // Both surfaces are rubbed the same way round: dw = -3/(2R) n x dv for b, and the same for a.
    const Vector3 spun = -1.5 / model.radius * n.cross(0.5 * rubbed);
    a.spin += spun;
    b.spin += spun;
  }
  a.velocity -= 0.5 * change;
  b.velocity += 0.5 * change;
}

namespace {

// Balls that bounce for ever lie: they fly on, are put back onto what they sink into and lose the speed
// towards it.
void lie(const BallModel& model, std::span<const BouncePlane> planes, std::span<BallState> balls, double h) {
  for (auto& ball : balls) ball = fly(model, ball, h);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    for (std::size_t k = i + 1; k < balls.size(); ++k) {
      const Vector3 apart = balls[k].position - balls[i].position;
      const double missing = 2.0 * model.radius - apart.norm();
      if (missing <= 0.0) continue;
      const Vector3 n = apart.normalized();
      balls[i].position -= 0.5 * missing * n;
      balls[k].position += 0.5 * missing * n;
      collide(model, {0.0, 0.0}, balls[i], balls[k]);
    }
  }
  for (auto& ball : balls) {
    for (const auto& plane : planes) {
      const double above = plane.normal.dot(ball.position - plane.point);
      if (above >= 0.0 || above < -model.radius || !plane.covers(ball.position)) continue;
      ball.position -= above * plane.normal;
      ball.velocity -= std::min(0.0, plane.normal.dot(ball.velocity)) * plane.normal;
    }
  }
}

}  // namespace

int advance_all(const BallModel& model, std::span<const BouncePlane> planes, const Bounce& between,
                std::span<BallState> balls, double dt, double max_step) {
  const int most = 64 * static_cast<int>(balls.size());
  int impacts = 0;
  while (dt > 0.0) {
    double first = std::min(dt, max_step);
    if (impacts >= most) {
      lie(model, planes, balls, first);
      dt -= first;
      continue;
    }
    const BouncePlane* plane = nullptr;
    BallState *one = nullptr, *other = nullptr;
    for (std::size_t i = 0; i < balls.size(); ++i) {
      if (const auto hit = first_plane_hit(model, planes, balls[i], first)) {
        first = hit->after;
        plane = hit->plane;
        one = &balls[i];
        other = nullptr;
      }
      for (std::size_t k = i + 1; k < balls.size(); ++k) {
        const auto touch = first_touch(model, balls[i], balls[k], first);
        if (!touch || (one != nullptr && *touch >= first)) continue;
        first = *touch;
        one = &balls[i];
        other = &balls[k];
      }
    }
    for (auto& ball : balls) ball = fly(model, ball, first);
    dt -= first;
    if (one == nullptr) continue;
    ++impacts;
    if (other != nullptr) {
      collide(model, between, *one, *other);
    } else {
      bounce_at(model, *plane, *one);
    }
  }
  return impacts;
}

}  // namespace palpate::physics
