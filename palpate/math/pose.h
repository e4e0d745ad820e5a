// Typed points, directions and rigid poses: a wrong chain of frames does not compile.
//
// Pose<A, B> is the pose of frame B in frame A; it maps B coordinates to A coordinates. Written X_A_B, so
// that neighbours cancel: X_world_tip = X_world_base * X_base_tip. Metres; unit quaternions. Values, freely
// copied, no thread rule. After Murray, Li, Sastry (1994), chapter 2; notation as in Drake's multibody
// documentation.
#pragma once

#include <type_traits>

#include "palpate/math/frames.h"
#include "palpate/math/so3.h"

namespace palpate::inline math {

// A place, seen from frame F.
template <typename F>
struct Point {
  Vector3 m = Vector3::Zero();
};

// A direction, velocity or displacement, seen from frame F.
template <typename F>
struct Direction {
  Vector3 v = Vector3::Zero();
};

template <typename F>
Direction<F> operator-(const Point<F>& a, const Point<F>& b) {
  return {a.m - b.m};
}
template <typename F>
Point<F> operator+(const Point<F>& a, const Direction<F>& b) {
  return {a.m + b.v};
}

template <typename A, typename B>
struct Pose {
  Quaternion rotation = Quaternion::Identity();
  Vector3 translation = Vector3::Zero();

  static Pose identity() { return {}; }

  Pose<B, A> inverse() const {
    const Quaternion r = rotation.conjugate();
    return {r, -(r * translation)};
  }
  Point<A> operator*(const Point<B>& p) const { return {rotation * p.m + translation}; }
  Direction<A> operator*(const Direction<B>& d) const { return {rotation * d.v}; }
  Matrix3 matrix() const { return rotation.toRotationMatrix(); }
};

template <typename A, typename B, typename C>
Pose<A, C> operator*(const Pose<A, B>& X_a_b, const Pose<B, C>& X_b_c) {
  return {(X_a_b.rotation * X_b_c.rotation).normalized(),
          X_a_b.rotation * X_b_c.translation + X_a_b.translation};
}

// For tests of what must not compile.
template <typename X, typename Y>
concept Composable = requires(const X& x, const Y& y) {
  x* y;
};

// Pose between two poses: 0 gives a, 1 gives b; rotation along the shortest arc.
template <typename A, typename B>
Pose<A, B> interpolate(const Pose<A, B>& a, const Pose<A, B>& b, double s) {
  return {a.rotation.slerp(s, b.rotation), (1.0 - s) * a.translation + s * b.translation};
}

}  // namespace palpate::inline math
