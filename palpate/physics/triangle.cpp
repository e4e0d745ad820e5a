#include "palpate/physics/triangle.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::physics {
namespace {

constexpr double kDoubleEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kThin = 1e-8;     // of the longest edge; thinner, and the normal is made of rounding
constexpr double kSlender = 0.05;  // thinner, and its last digits are
constexpr double kSeam = 1e-3;     // thinner, and too many are to tell a seam

// Earliest moment in [0, 1] at which |m + s d| = r, coming from outside. What stands under the root is taken
// from the vector of closest approach, since b^2 - ac would lose a small sphere far away among the digits
// (Haines, Gunther and Akenine-Moeller 2019).
bool enter(const Vector3& m, const Vector3& d, double r, double& s) {
  const double a = d.squaredNorm(), b = m.dot(d);
  if (!(a > 0.0) || !(b < 0.0)) return false;
  const double off2 = r * r - (m - (b / a) * d).squaredNorm();
  if (!(off2 >= 0.0)) return false;
  const double far = m.norm();
  s = (far - r) * (far + r) / (-b + std::sqrt(a * off2));  // the smaller root without cancellation
  return s <= 1.0;
}

// Unit normal, or zero where the triangle is too thin to have one; and its width by its longest edge.
Vector3 unit_normal(const Triangle& t, double& width) {
  const Vector3 e1 = t[1] - t[0], e2 = t[2] - t[0], e3 = t[2] - t[1];
  const Vector3 face = e1.cross(e2);
  const double longest = std::max({e1.squaredNorm(), e2.squaredNorm(), e3.squaredNorm()});
  const double area = face.norm();
  width = longest > 0.0 ? area / longest : 0.0;
  return width > kThin ? Vector3(face / area) : Vector3(Vector3::Zero());
}

// A touch of a slender triangle's face, put right by the closest point, whose distance is good to the square
// of what its place is off.
void refine(const Triangle& t, const Vector3& from, const Vector3& d, double radius, SweepHit& hit) {
  for (int i = 0; i < 2; ++i) {
    const Vector3 centre = from + hit.fraction * d;
    const Vector3 foot = closest_point(t, centre), out = centre - foot;
    const double distance = out.norm(), sinking = -out.dot(d) / distance;
    if (!(sinking > 0.0)) return;
    hit.fraction = std::clamp(hit.fraction + (distance - radius) / sinking, 0.0, 1.0);
    hit.normal = out / distance;
    hit.point = foot;
  }
}

}  // namespace

Vector3 closest_point(const Triangle& t, const Vector3& p) {
  // Ericson 2005, 5.1.5: by the Voronoi region of the triangle p lies in. An edge of no length has no region.
  const Vector3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return t[0];
  const Vector3 bp = p - t[1];
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return t[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3) return t[0] + d1 / (d1 - d3) * ab;
  const Vector3 cp = p - t[2];
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return t[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6) return t[0] + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  const double along = d4 - d3, back = d5 - d6;
  if (va <= 0.0 && along >= 0.0 && back >= 0.0 && along + back > 0.0) {
    return t[1] + along / (along + back) * (t[2] - t[1]);
  }
  const double sum = va + vb + vc;
  if (!(sum > 0.0)) return t[0];
  return t[0] + vb / sum * ab + vc / sum * ac;
}

std::optional<SweepHit> sweep_sphere(const Triangle& t, const Vector3& from, const Vector3& to, double radius,
                                     double latest) {
  const Vector3 d = to - from;
  double width = 0.0;
  const Vector3 n = unit_normal(t, width);
  const bool flat = n.squaredNorm() > 0.0;
  SweepHit hit;

  const double height = n.dot(from - t[0]);
  const double side = height < 0.0 ? -1.0 : 1.0;
  const double sinking = -side * n.dot(d);
  const bool off_slab = flat && side * height > radius;
  if (off_slab) {
    // The plate: entering it is entering the grown triangle, nothing else can come earlier.
    if (!(sinking > 0.0)) return std::nullopt;
    const double s = (side * height - radius) / sinking;
    // Not even the slab around the plane is reached; where the plane is not sure, by now.
    if (s > (width < kSlender ? 1.0 : latest)) return std::nullopt;
    const Vector3 p = from + s * d - side * radius * n;
    bool inside = true;
    for (std::size_t i = 0; i < 3 && inside; ++i) {
      inside = n.dot((t[(i + 1) % 3] - t[i]).cross(p - t[i])) >= 0.0;
    }
    if (inside) {
      hit.fraction = s;
      hit.normal = side * n;
      hit.point = p;
      if (width < kSlender) refine(t, from, d, radius, hit);
      return hit;
    }
  }
  const Vector3 start = closest_point(t, from);
  const double distance = (from - start).norm();
  if (!off_slab && distance <= radius) {
    // On the surface itself only the motion tells the side.
    hit.normal = distance > 1e-10 * radius ? Vector3((from - start) / distance)
                                           : Vector3(n.dot(d) > 0.0 ? Vector3(-n) : n);
    if (!(hit.normal.dot(d) < 0.0)) return std::nullopt;
    hit.point = start;
    hit.overlapped = true;
    return hit;
  }
  // All of the triangle lies behind the plane through its closest point, across the line to it: most are told
  // by how far the motion goes towards that plane. Of a slender triangle the closest point is not that sure.
  const double rounding = 64.0 * kDoubleEpsilon *
                          (from.cwiseAbs().maxCoeff() + t[0].cwiseAbs().maxCoeff() + d.cwiseAbs().maxCoeff());
  const double nearing = latest * std::min(0.0, (from - start).dot(d) / distance);
  if (width >= kSlender && distance + nearing > radius + rounding) return std::nullopt;

  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    double s = 0.0;
    const Vector3 m = from - t[i];
    if (enter(m, d, radius, s)) best = std::min(best, s);
    const Vector3 edge = t[(i + 1) % 3] - t[i];
    const double ee = edge.squaredNorm();
    if (ee <= 0.0) continue;
    // Across the edge's axis only.
    const double me = m.dot(edge), de = d.dot(edge);
    if (enter(m - (me / ee) * edge, d - (de / ee) * edge, radius, s) && s >= 0.0) {
      const double along = (me + s * de) / ee;
      if (along >= 0.0 && along <= 1.0) best = std::min(best, s);
    }
  }
  if (!(best <= latest)) return std::nullopt;
  hit.fraction = std::max(best, 0.0);
  const Vector3 centre = from + hit.fraction * d;
  hit.point = closest_point(t, centre);
  const Vector3 out = centre - hit.point;
  const double off = out.norm();
  if (!(off > 0.0)) return std::nullopt;
  hit.normal = out / off;
  // Touched where edge and face are equally near to rounding: the face's normal. Over the seam of two level
  // triangles the edge's own would lean by the square root of that rounding, 1e-7.
  const double above = n.dot(centre - t[0]);
  if (width > kSeam && std::abs(above) >= radius - rounding) hit.normal = above < 0.0 ? Vector3(-n) : n;
  return hit;
}

std::optional<double> ray_triangle(const Triangle& t, const Vector3& from, const Vector3& to) {
  // Woop, Benthin, Wald 2013: sheared so that the ray runs along its largest axis; then the two triangles of
  // an edge compute the same numbers for it, with opposite signs.
  const Vector3 d = to - from;
  Eigen::Index kz = 0;
  d.cwiseAbs().maxCoeff(&kz);
  const Eigen::Index kx = (kz + 1) % 3, ky = (kz + 2) % 3;
  if (!(d[kz] != 0.0)) return std::nullopt;
  const double sx = d[kx] / d[kz], sy = d[ky] / d[kz];
  const Vector3 a = t[0] - from, b = t[1] - from, c = t[2] - from;
  const double ax = a[kx] - sx * a[kz], ay = a[ky] - sy * a[kz];
  const double bx = b[kx] - sx * b[kz], by = b[ky] - sy * b[kz];
  const double cx = c[kx] - sx * c[kz], cy = c[ky] - sy * c[kz];
  const double u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
  if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return std::nullopt;
  const double det = u + v + w;
  if (!(det != 0.0)) return std::nullopt;
  const double fraction = (u * a[kz] + v * b[kz] + w * c[kz]) / (det * d[kz]);
  if (!(fraction >= 0.0 && fraction <= 1.0)) return std::nullopt;
  return fraction;
}

}  // namespace palpate::physics
