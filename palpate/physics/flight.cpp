#include "palpate/physics/flight.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "palpate/core/text.h"
#include "palpate/math/levenberg_marquardt.h"

namespace palpate::physics {

bool BouncePlane::covers(const Vector3& centre) const {
  if (!half_sides) return true;
  for (const auto& side : *half_sides) {
    if (std::abs((centre - point).dot(side)) > side.squaredNorm()) return false;
  }
  return true;
}

BouncePlane bounce_plane(const std::array<Vector3, 4>& corners, double radius, const Bounce& law) {
  BouncePlane plane;
  const Vector3 x = corners[1] - corners[0], y = corners[3] - corners[0];
  plane.normal = x.cross(y).normalized();
  plane.point = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]) + radius * plane.normal;
  plane.law = law;
  plane.half_sides = std::array<Vector3, 2>{Vector3(0.5 * x), Vector3(0.5 * y)};
  return plane;
}

std::optional<PlaneHit> first_plane_hit(const BallModel& model, std::span<const BouncePlane> planes,
                                        const BallState& ball, double h) {
  const BallState next = fly(model, ball, h);
  std::optional<PlaneHit> first;
  for (const auto& plane : planes) {
    const double above = plane.normal.dot(ball.position - plane.point);
    const double below = plane.normal.dot(next.position - plane.point);
    if (above < -1e-6 || below >= 0.0 || plane.normal.dot(next.velocity) >= 0.0) continue;
    // Found on the chord and sharpened on the flight itself.
    double s = h * std::max(above, 0.0) / std::max(above - below, 1e-300);
    for (int i = 0; i < 4; ++i) {
      const BallState at = fly(model, ball, s);
      const double speed = plane.normal.dot(at.velocity);
      if (speed >= 0.0) break;
      s = std::clamp(s - plane.normal.dot(at.position - plane.point) / speed, 0.0, h);
    }
    if (s < (first ? first->after : h) && plane.covers(fly(model, ball, s).position))
      first = PlaneHit{s, &plane};
  }
  return first;
}

void bounce_at(const BallModel& model, const BouncePlane& plane, BallState& ball) {
  ball.position -= std::min(0.0, plane.normal.dot(ball.position - plane.point)) * plane.normal;
  ball = bounce(model, ball, plane.normal, plane.law);
}

int advance(const BallModel& model, std::span<const BouncePlane> planes, BallState& ball, double dt,
            double max_step) {
  constexpr int kMostBounces = 64;  // a ball at rest on a plane would bounce for ever
  int bounces = 0;
  while (dt > 0.0) {
    const double h = std::min(dt, max_step);
    const auto hit = first_plane_hit(model, planes, ball, h);
    if (!hit) {
      ball = fly(model, ball, h);
      dt -= h;
      continue;
    }
    if (bounces >= kMostBounces) {  // rolls on
      ball = fly(model, ball, h);
      const auto& plane = *hit->plane;
      ball.position -= std::min(0.0, plane.normal.dot(ball.position - plane.point)) * plane.normal;
      ball.velocity -= std::min(0.0, plane.normal.dot(ball.velocity)) * plane.normal;
      dt -= h;
      continue;
    }
    ball = fly(model, ball, hit->after);
    bounce_at(model, *hit->plane, ball);
    ++bounces;
    dt -= hit->after;
  }
  return bounces;
}

namespace {

// The unknowns of a fit: place and velocity (6), or these and the spin (9) in units of kSpinUnit, which
// bends a flight about as much as a velocity of 1 m/s does.
constexpr double kSpinUnit = 100.0;  // rad/s
constexpr double kSpinExpected =
    150.0;                            // rad/s, of nine rally balls in ten; holds what a flight does not tell
constexpr double kSeenError = 0.003;  // m, of a good camera system: what that expectation is weighed against

struct Fitted {
  Eigen::VectorXd x;
  double cost = 0.0;  // of the places alone, m^2
  double held = 0.0;  // the cost that was minimised: places and what is expected of the spin
  int iterations = 0;
};

BallState state_of(const Eigen::VectorXd& x, const Vector3& spin) {
  return {x.head<3>(), x.segment<3>(3), x.size() > 6 ? Vector3(kSpinUnit * x.tail<3>()) : spin};
}

// Straight parabola through the first observations, where the search starts.
Vector6 parabola(const BallModel& model, std::span<const SeenBall> seen) {
  const double span = std::min(0.1, 0.6 * (seen.back().time - seen.front().time));
  double n = 0, st = 0, stt = 0;
  Vector3 sp = Vector3::Zero(), stp = Vector3::Zero();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double t = seen[i].time - seen[0].time;
    if (i >= 3 && t > span) break;
    const Vector3 p = seen[i].position - 0.5 * t * t * model.gravity;
    n += 1;
    st += t;
    stt += t * t;
    sp += p;
    stp += t * p;
  }
  const double det = n * stt - st * st;
  Vector6 x;
  x << (stt * sp - st * stp) / det, (n * stp - st * sp) / det;
  return x;
}

Expected<void> can_be_fitted(std::span<const SeenBall> seen, std::size_t least) {
  if (seen.size() < least)
    return refused("flight: {}, needs at least {}", counted(seen.size(), "observation"), least);
  for (std::size_t i = 1; i < seen.size(); ++i) {
    const double step = seen[i].time - seen[i - 1].time;
    if (!(step > 0.0))
      return refused("flight: observation {} at {} s is not later than the one before it; sort them", i + 1,
                     seen[i].time);
    constexpr double kLeastStep =
        1e-6;  // s: no camera is as fast, and shorter ones lose themselves in rounding
    if (step < kLeastStep)
      return refused(
          "flight: observation {} comes {:.2g} s after the one before it, at least {:g} s are expected; "
          "check the unit of the times",
          i + 1, step, kLeastStep);
  }
  return {};
}

// From `x` on. Derivatives by differences: a flight through bounces has none in closed form.
Fitted minimise_misses(const BallModel& model, std::span<const BouncePlane> planes,
                       std::span<const SeenBall> seen, Eigen::VectorXd x, const Vector3& spin) {
  const bool spin_is_free = x.size() > 6;
  const double hold = spin_is_free ? std::pow(kSeenError * kSpinUnit / kSpinExpected, 2) : 0.0;
  const auto misses = [&](const Eigen::VectorXd& y) {
    BallState ball = state_of(y, spin);
    Eigen::VectorXd r(3 * static_cast<Eigen::Index>(seen.size()));
    for (std::size_t i = 0; i < seen.size(); ++i) {
      advance(model, planes, ball, i == 0 ? 0.0 : seen[i].time - seen[i - 1].time);
      r.segment<3>(3 * static_cast<Eigen::Index>(i)) = ball.position - seen[i].position;
    }
    return r;
  };
  const auto evaluate = [&](const Eigen::VectorXd& y, NormalEquations<Eigen::Dynamic>* equations) {
    const Eigen::VectorXd r = misses(y);
    if (equations) {
      constexpr double kStep = 1e-6;  // m, m/s, kSpinUnit
      Eigen::MatrixXd J(r.size(), y.size());
      for (Eigen::Index k = 0; k < y.size(); ++k) {
        Eigen::VectorXd ahead = y;
        ahead[k] += kStep;
        J.col(k) = (misses(ahead) - r) / kStep;
      }
      equations->add(J, r);
      if (spin_is_free) {
        equations->JtJ.diagonal().tail<3>().array() += hold;
        equations->Jtr.tail<3>() += hold * y.tail<3>();
      }
    }
    return r.squaredNorm() + (spin_is_free ? hold * y.tail<3>().squaredNorm() : 0.0);
  };
  const auto solved = minimise(x, evaluate, {.most_iterations = 20, .tolerance = 1e-7});
  return {x, misses(x).squaredNorm(), evaluate(x, nullptr), solved.iterations};
}

Expected<FlightFit> result_of(const Fitted& fitted, std::span<const SeenBall> seen, const Vector3& spin) {
  if (!std::isfinite(fitted.held))
    return refused("flight: no ball flies through these {} observations; check times and places",
                   seen.size());
  return FlightFit{state_of(fitted.x, spin), seen[0].time,
                   std::sqrt(fitted.cost / (3.0 * static_cast<double>(seen.size()))), fitted.iterations};
}

}  // namespace

Expected<FlightFit> fit_flight(const BallModel& model, std::span<const BouncePlane> planes,
                               std::span<const SeenBall> seen, const Vector3& spin) {
  if (const auto can = can_be_fitted(seen, 3); !can) return tl::unexpected(can.error());
  return result_of(minimise_misses(model, planes, seen, parabola(model, seen), spin), seen, spin);
}

Expected<FlightFit> fit_flight_and_spin(const BallModel& model, std::span<const BouncePlane> planes,
                                        std::span<const SeenBall> seen) {
  if (const auto can = can_be_fitted(seen, 6); !can) return tl::unexpected(can.error());
  const Vector6 still = parabola(model, seen);
  const Vector3 up = -model.gravity.normalized();
  const Vector3 top = up.cross(still.tail<3>()).normalized();  // the axis of topspin
  // Drag does not care for the sign of a spin: a search begun at none would not know which way to go.
  constexpr double kStart = 50.0 / kSpinUnit;
  std::optional<Fitted> best;
  for (const Vector3& axis : {top, Vector3(-top), up, Vector3(-up)}) {
    Eigen::VectorXd x(9);
    x << still, kStart * axis;
    auto fitted = minimise_misses(model, planes, seen, x, Vector3::Zero());
    if (std::isfinite(fitted.held) && (!best || fitted.held < best->held)) best = std::move(fitted);
  }
  if (!best)
    return refused("flight: no ball flies through these {} observations; check times and places",
                   seen.size());
  return result_of(*best, seen, Vector3::Zero());
}

}  // namespace palpate::physics
