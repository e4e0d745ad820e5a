#include "palpate/physics/flight.h"

#include <algorithm>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/estimation/linear_algebra.h"

namespace palpate {

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

int advance(const BallModel& model, std::span<const BouncePlane> planes, BallState& ball, double dt,
            double max_step) {
  constexpr int kMostBounces = 64;  // a ball at rest on a plane would bounce for ever
  int bounces = 0;
  while (dt > 0.0) {
    const double h = std::min(dt, max_step);
    const BallState next = fly(model, ball, h);
    // The earliest crossing within the step, found on the chord and sharpened on the flight itself.
    double first = h;
    const BouncePlane* met = nullptr;
    for (const auto& plane : planes) {
      const double above = plane.normal.dot(ball.position - plane.point);
      const double below = plane.normal.dot(next.position - plane.point);
      if (above < -1e-6 || below >= 0.0 || plane.normal.dot(next.velocity) >= 0.0) continue;
      double s = h * std::max(above, 0.0) / std::max(above - below, 1e-300);
      for (int i = 0; i < 4; ++i) {
        const BallState at = fly(model, ball, s);
        const double speed = plane.normal.dot(at.velocity);
        if (speed >= 0.0) break;
        s = std::clamp(s - plane.normal.dot(at.position - plane.point) / speed, 0.0, h);
      }
      if (s < first && plane.covers(fly(model, ball, s).position)) {
        first = s;
        met = &plane;
      }
    }
    if (met == nullptr) {
      ball = next;
      dt -= h;
      continue;
    }
    if (bounces >= kMostBounces) {  // rolls on
      ball = next;
      ball.position -= std::min(0.0, met->normal.dot(ball.position - met->point)) * met->normal;
      ball.velocity -= std::min(0.0, met->normal.dot(ball.velocity)) * met->normal;
      dt -= h;
      continue;
    }
    ball = fly(model, ball, first);
    ball.position -= std::min(0.0, met->normal.dot(ball.position - met->point)) * met->normal;
    ball = bounce(model, ball, met->normal, met->law);
    ++bounces;
    dt -= first;
  }
  return bounces;
}

namespace {

BallState state_of(const Vector6& x, const Vector3& spin) { return {x.head<3>(), x.tail<3>(), spin}; }

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

}  // namespace

Expected<FlightFit> fit_flight(const BallModel& model, std::span<const BouncePlane> planes,
                               std::span<const SeenBall> seen, const Vector3& spin) {
  if (seen.size() < 3) return refused("flight: {}, needs at least 3", counted(seen.size(), "observation"));
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
          "check "
          "the unit of the times",
          i + 1, step, kLeastStep);
  }
  const double t0 = seen[0].time;
  const auto places = [&](const Vector6& x, std::vector<Vector3>& out) {
    BallState ball = state_of(x, spin);
    out.clear();
    for (std::size_t i = 0; i < seen.size(); ++i) {
      advance(model, planes, ball, i == 0 ? 0.0 : seen[i].time - seen[i - 1].time);
      out.push_back(ball.position);
    }
  };
  const auto cost = [&](const std::vector<Vector3>& at) {
    double sum = 0.0;
    for (std::size_t i = 0; i < seen.size(); ++i) sum += (at[i] - seen[i].position).squaredNorm();
    return sum;
  };

  Vector6 x = parabola(model, seen);
  std::vector<Vector3> at, moved;
  places(x, at);
  double best = cost(at), damping = 1e-9;
  int iterations = 0;
  for (; iterations < 20; ++iterations) {
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    std::vector<Eigen::Matrix<double, 3, 6>> J(seen.size());
    for (Eigen::Index k = 0; k < 6; ++k) {
      constexpr double kStep = 1e-6;  // m and m/s
      Vector6 y = x;
      y[k] += kStep;
      places(y, moved);
      for (std::size_t i = 0; i < seen.size(); ++i) J[i].col(k) = (moved[i] - at[i]) / kStep;
    }
    for (std::size_t i = 0; i < seen.size(); ++i) {
      H += J[i].transpose() * J[i];
      g += J[i].transpose() * (at[i] - seen[i].position);
    }
    bool better = false;
    for (int attempt = 0; attempt < 8 && !better; ++attempt) {  // Levenberg: a bounce makes the way uneven
      const Matrix6 damped = H + damping * Matrix6(H.diagonal().asDiagonal());
      const Vector6 y = x - solve_symmetric(damped, g);
      places(y, moved);
      const double c = cost(moved);
      if (std::isfinite(c) && c <= best) {
        better = best - c > 1e-12 * best;
        x = y;
        at.swap(moved);
        best = c;
        damping = std::max(0.1 * damping, 1e-12);
        break;
      }
      damping = std::max(10.0 * damping, 1e-6);
    }
    if (!better) break;
  }
  if (!std::isfinite(best))
    return refused("flight: no ball flies through these {} observations; check times and places",
                   seen.size());
  return FlightFit{state_of(x, spin), t0, std::sqrt(best / (3.0 * static_cast<double>(seen.size()))),
                   iterations};
}

}  // namespace palpate
