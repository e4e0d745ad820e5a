// When a sphere touches triangles, found without the sweep's mathematics and in 80-bit floats: the distance
// of the centre from a triangle is the least of its feet on face, edges and corners; along a straight path it
// is convex, so its lowest place is found by thirds and the touch before it by halves. For tests only.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "palpate/physics/triangle.h"

namespace palpate::physics::reference {

using Long = long double;
using Long3 = Eigen::Matrix<Long, 3, 1>;

inline Long distance(const Triangle& triangle, const Long3& p) {
  const std::array<Long3, 3> t{triangle[0].cast<Long>(), triangle[1].cast<Long>(), triangle[2].cast<Long>()};
  Long best = HUGE_VALL;
  for (std::size_t i = 0; i < 3; ++i) {
    const Long3 e = t[(i + 1) % 3] - t[i], m = p - t[i];
    const Long ee = e.squaredNorm();
    const Long s = ee > 0 ? std::clamp<Long>(m.dot(e) / ee, 0, 1) : 0;
    best = std::min(best, (m - s * e).norm());
  }
  const Long3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  if (!(n.norm() > 0)) return best;
  for (std::size_t i = 0; i < 3; ++i)
    if (n.dot((t[(i + 1) % 3] - t[i]).cross(p - t[i])) < 0) return best;
  return std::min(best, std::abs(n.dot(p - t[0])) / n.norm());
}

struct Path {
  Long3 from, d;
  Long3 at(Long s) const { return from + s * d; }
};
inline Path path(const Vector3& from, const Vector3& to) {
  return {from.cast<Long>(), (to - from).cast<Long>()};
}

inline Long distance(std::span<const Triangle> triangles, const Long3& p) {
  Long best = HUGE_VALL;
  for (const auto& t : triangles) best = std::min(best, distance(t, p));
  return best;
}

struct Nearest {
  Long fraction, distance;
};
inline Nearest nearest(const Triangle& t, const Path& path) {
  Long low = 0, high = 1;
  for (int i = 0; i < 160; ++i) {
    const Long a = low + (high - low) / 3, b = high - (high - low) / 3;
    (distance(t, path.at(a)) <= distance(t, path.at(b)) ? high : low) =
        distance(t, path.at(a)) <= distance(t, path.at(b)) ? b : a;
  }
  Nearest best{0, distance(t, path.at(0))};
  for (const Long s : {low, high, Long(1)})
    if (const Long r = distance(t, path.at(s)); r < best.distance) best = {s, r};
  return best;
}

// First touch in (0, 1] of a sphere that does not overlap at the start; 2 where there is none.
inline Long touch(const Triangle& t, const Path& path, Long radius) {
  const Nearest n = nearest(t, path);
  if (n.distance > radius) return 2;
  Long low = 0, high = n.fraction;
  for (int i = 0; i < 80; ++i) {
    const Long s = (low + high) / 2;
    (distance(t, path.at(s)) > radius ? low : high) = s;
  }
  return high;
}

}  // namespace palpate::physics::reference
