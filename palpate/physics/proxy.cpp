// Legend: x proxy, g tip (goal), R radius, n and o normal and offset of a plane n . x >= o.
// A triangle grown by R is convex. Where a straight path first meets it, the plane through the touched point
// with the normal of touch has all of it on one side and the path's start on the other, so that moving within
// such half-spaces cannot enter the triangles they came from; whatever else is in the way the next sweep
// finds.
#include "palpate/physics/proxy.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace palpate::physics {
namespace {

// Shares of the radius. The skin keeps rounding from taking a sphere that slides for one that overlaps: 3 nm
// for a tip of 3 mm, a million times what doubles resolve at arm's length. What moves less stands still: at
// 600 N/m that is 0.06 mN.
constexpr double kSkin = 1e-6, kStill = 3e-5;
constexpr int kPasses = 3;
constexpr double kTurned = 0.01;  // rad, of the normal: a hundredth of the friction

const ProxySettings& checked(const ProxySettings& s) {
  if (!(s.radius > 0.0) || !std::isfinite(s.radius))
    throw std::invalid_argument(fmt::format(
        "proxy: radius {} m; a sphere of more than 0 is expected, 0.003 is the tip of a stylus", s.radius));
  if (!(s.friction >= 0.0 && s.friction <= 2.0))
    throw std::invalid_argument(
        fmt::format("proxy: friction {}; 0 (none) to 2 (rubber) is expected", s.friction));
  if (!(s.static_friction >= 0.0 && s.static_friction <= 2.0))
    throw std::invalid_argument(
        fmt::format("proxy: static friction {}; 0 (none) to 2 (rubber) is expected", s.static_friction));
  if (s.most_sweeps < 8 || s.most_sweeps > 100)
    throw std::invalid_argument(fmt::format("proxy: {} sweeps; 8 to 100 are expected", s.most_sweeps));
  return s;
}

}  // namespace

Proxy::Proxy(const CollisionMesh& mesh, const ProxySettings& settings)
    : mesh_(mesh),
      settings_(checked(settings)),
      skin_(kSkin * settings.radius),
      still_(kStill * settings.radius) {}

bool Proxy::clear_at(const Vector3& p) const {
  // A sphere that overlaps goes deeper along at least one of these.
  for (int i = 0; i < 6; ++i) {
    const Vector3 step = (i % 2 == 0 ? still_ : -still_) * Vector3::Unit(i / 2);
    if (mesh_.sweep(p, p + step, settings_.radius + still_)) return false;
  }
  return true;
}

void Proxy::begin(const Vector3& p) {
  state_ = ProxyState{};
  state_.position = p;
  plane_count_ = 0;
}

// A new contact; where there is no room the older ones go, and come back where they still matter.
void Proxy::constrain(const SweepHit& hit) {
  if (plane_count_ == kPlanes) plane_count_ = 0;
  planes_[plane_count_++] = {hit.normal, hit.normal.dot(hit.point) + settings_.radius + skin_};
}

bool Proxy::allowed(const Vector3& x) const {
  for (std::size_t i = 0; i < plane_count_; ++i)
    if (planes_[i].normal.dot(x) < planes_[i].offset - 0.25 * skin_) return false;
  return true;
}

// min |x - g|^2 with n_i . x >= o_i: no more than three planes carry the answer. The first set whose
// multipliers are not negative and whose point keeps to all planes is it (Karush, Kuhn and Tucker; the
// problem is convex).
Vector3 Proxy::nearest_allowed(const Vector3& g, const Vector3& here) const {
  if (allowed(g)) return g;
  const std::size_t count = plane_count_;
  constexpr double kParallel = 1e-10;  // of a determinant of unit normals
  const auto lack = [&](std::size_t i) { return planes_[i].offset - planes_[i].normal.dot(g); };
  for (std::size_t i = 0; i < count; ++i) {
    const double a = lack(i);
    if (a <= 0.0) continue;
    const Vector3 x = g + a * planes_[i].normal;
    if (allowed(x)) return x;
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      const Vector3 &m = planes_[i].normal, &n = planes_[j].normal;
      const double c = m.dot(n), det = 1.0 - c * c;
      if (det < kParallel) continue;
      const double a = lack(i) - c * lack(j), b = lack(j) - c * lack(i);
      if (a < 0.0 || b < 0.0) continue;
      const Vector3 x = g + a / det * m + b / det * n;
      if (allowed(x)) return x;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      for (std::size_t k = j + 1; k < count; ++k) {
        Matrix3 N;
        N << planes_[i].normal, planes_[j].normal, planes_[k].normal;
        const Matrix3 gram = N.transpose() * N;
        if (gram.determinant() < kParallel) continue;
        const Vector3 l = gram.inverse() * Vector3(lack(i), lack(j), lack(k));
        if (l.minCoeff() < 0.0) continue;
        const Vector3 x = g + N * l;
        if (allowed(x)) return x;
      }
    }
  }
  return here;  // wedged between planes that leave no room
}

// Straight on until something is in the way, which then becomes a plane, with the skin kept free; false where
// it comes to `to`.
bool Proxy::go(Vector3& x, const Vector3& to) {
  ++state_.sweeps;
  const Vector3 from = x;
  const auto hit = mesh_.sweep(from, to, settings_.radius);
  x = to;
  if (!hit) return false;
  constrain(*hit);
  const double sinking = -hit->normal.dot(to - from);
  x = sinking > 0.0 ? Vector3(from + std::max(0.0, hit->fraction - skin_ / sinking) * (to - from)) : from;
  return true;
}

// Moves x to the place nearest to `goal` that can be reached downhill in distance: straight on, constrained
// by what is in the way, along it, until nothing new is found.
void Proxy::slide(Vector3& x, const Vector3& goal) {
  state_.settled = false;
  // The planes of the last time are where a slide usually goes on; what they say must be found true here.
  bool fresh = plane_count_ == 0;  // every plane was found where x is now
  bool round = fresh;              // every plane was found since the last time there was none
  Vector3 begun = x;               // where x was then
  while (state_.sweeps < settings_.most_sweeps) {
    const Vector3 target = nearest_allowed(goal, x);
    const bool arrived = (target - x).norm() <= still_;
    if (arrived && fresh) {
      state_.settled = true;
      return;
    }
    if (!arrived) {
      const Vector3 from = x;
      const bool alone = plane_count_ == 0;
      if (go(x, target)) {
        if ((x - from).norm() > still_) fresh = alone;  // the one plane there is was found here
        continue;
      }
    }
    // Nothing in the way any more: what led here may have been left behind. Where a whole round brought
    // nothing there is nothing to be had (on almost parallel planes the skin alone can lead round in a ring).
    if (round && ((x - begun).norm() <= still_ || (begun - goal).norm() - (x - goal).norm() <= 0.1 * skin_)) {
      state_.settled = true;
      return;
    }
    plane_count_ = 0;
    fresh = round = true;
    begun = x;
  }
}

const ProxyState& Proxy::follow(const Vector3& tip) {
  if (!tip.allFinite()) return state_;
  state_.sweeps = 0;
  state_.settled = true;
  Vector3 x = state_.position;
  const Vector3 start = x;
  Vector3 goal = tip;
  if (state_.touching && std::max(settings_.friction, settings_.static_friction) > 0.0) {
    // Inside the cone the proxy stays. Else it goes until the tip is on the cone: until the tip, shifted back
    // by the cone's radius, is straight below. The normal changes on the way, so that is done over again.
    Vector3 n = state_.normal;
    for (int pass = 0; pass < kPasses; ++pass) {
      const double depth = n.dot(x - tip);
      const Vector3 aside = x - tip - depth * n;
      const double cone = settings_.friction * std::max(0.0, depth), offset = aside.norm();
      const double holds =
          state_.sliding ? cone : std::max(settings_.friction, settings_.static_friction) * depth;
      goal = tip;
      if (pass == 0 && depth > 0.0 && offset <= holds) {
        state_.sliding = false;
        state_.depth = depth;
        return state_;
      }
      if (offset > 0.0) goal += cone / offset * aside;
      slide(x, goal);
      const Vector3 push = x - goal;
      if (push.norm() <= still_) break;
      const Vector3 turned = push.normalized() - n;
      n += turned;
      if (turned.norm() < kTurned) break;
    }
  } else {
    slide(x, goal);
  }
  const Vector3 push = x - goal;
  state_.position = x;
  state_.depth = push.norm();
  state_.touching = state_.depth > still_;
  state_.sliding = state_.touching && (x - start).norm() > still_;
  if (state_.touching) {
    state_.normal = push / state_.depth;
  } else {
    state_.normal.setZero();
    state_.depth = 0.0;
  }
  return state_;
}

}  // namespace palpate::physics
