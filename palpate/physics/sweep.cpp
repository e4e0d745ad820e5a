#include "palpate/physics/sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace palpate {
namespace {

constexpr std::uint32_t kBruteForce = 64;  // triangles below which a tree does not pay
constexpr std::uint32_t kLeaf = 4;

// Earliest root in [0, 1] of |m + t d|^2 = r^2 coming from outside, in any number of dimensions folded into
// a = d.d, b = m.d, c = m.m - r^2 > 0.
bool enter(double a, double b, double c, double& t) {
  if (a <= 0.0 || b >= 0.0) return false;
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return false;
  t = c / (-b + std::sqrt(discriminant));  // the smaller root without cancellation
  return t <= 1.0;
}

}  // namespace

Vector3 closest_point(const Triangle& t, const Vector3& p) {
  // Ericson 2005, 5.1.5: by the Voronoi region of the triangle p lies in.
  const Vector3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return t[0];
  const Vector3 bp = p - t[1];
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return t[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return t[0] + d1 / (d1 - d3) * ab;
  const Vector3 cp = p - t[2];
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return t[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return t[0] + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    return t[1] + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (t[2] - t[1]);
  }
  const double scale = 1.0 / (va + vb + vc);
  return t[0] + vb * scale * ab + vc * scale * ac;
}

std::optional<SweepHit> sweep_sphere(const Triangle& t, const Vector3& from, const Vector3& to,
                                     double radius) {
  const Vector3 d = to - from;
  const Vector3 face = (t[1] - t[0]).cross(t[2] - t[0]);
  const double area = face.norm();
  const Vector3 n = area > 0.0 ? Vector3(face / area) : Vector3::Zero();
  SweepHit hit;

  const Vector3 start = closest_point(t, from);
  const double distance = (from - start).norm();
  if (distance <= radius) {
    // On the surface itself only the motion tells the side.
    hit.normal =
        distance > 1e-12 ? Vector3((from - start) / distance) : Vector3(n.dot(d) > 0.0 ? Vector3(-n) : n);
    if (hit.normal.dot(d) >= 0.0) return std::nullopt;
    hit.point = start;
    hit.overlapped = true;
    return hit;
  }

  double best = std::numeric_limits<double>::infinity();
  // The plate: entering it is entering the grown triangle, nothing else can come earlier.
  const double height = n.dot(from - t[0]);
  const double side = height < 0.0 ? -1.0 : 1.0;
  const double sinking = -side * n.dot(d);
  if (area > 0.0 && side * height >= radius && sinking > 0.0) {
    const double s = (side * height - radius) / sinking;
    if (s > 1.0) return std::nullopt;  // never reaches the slab around the plane
    const Vector3 p = from + s * d - side * radius * n;
    bool inside = true;
    for (std::size_t i = 0; i < 3 && inside; ++i) {
      inside = n.dot((t[(i + 1) % 3] - t[i]).cross(p - t[i])) >= 0.0;
    }
    if (inside) {
      hit.fraction = s;
      hit.normal = side * n;
      hit.point = p;
      return hit;
    }
  }
  const double dd = d.squaredNorm();
  for (std::size_t i = 0; i < 3; ++i) {
    double s = 0.0;
    const Vector3 m = from - t[i];
    if (enter(dd, m.dot(d), m.squaredNorm() - radius * radius, s)) best = std::min(best, s);
    const Vector3 edge = t[(i + 1) % 3] - t[i];
    const double ee = edge.squaredNorm();
    if (ee <= 0.0) continue;
    // Across the edge's axis only.
    const double me = m.dot(edge), de = d.dot(edge);
    const Vector3 m_across = m - (me / ee) * edge, d_across = d - (de / ee) * edge;
    if (enter(d_across.squaredNorm(), m_across.dot(d_across), m_across.squaredNorm() - radius * radius, s) &&
        s >= 0.0) {
      const double along = (me + s * de) / ee;
      if (along >= 0.0 && along <= 1.0) best = std::min(best, s);
    }
  }
  if (best > 1.0) return std::nullopt;
  hit.fraction = std::max(best, 0.0);
  const Vector3 centre = from + hit.fraction * d;
  hit.point = closest_point(t, centre);
  const Vector3 out = centre - hit.point;
  if (out.norm() <= 1e-12) return std::nullopt;
  hit.normal = out.normalized();
  return hit;
}

std::optional<double> ray_triangle(const Triangle& t, const Vector3& from, const Vector3& to) {
  const Vector3 d = to - from, e1 = t[1] - t[0], e2 = t[2] - t[0];
  const Vector3 p = d.cross(e2);
  const double det = e1.dot(p);
  if (std::abs(det) < 1e-30) return std::nullopt;
  const Vector3 s = from - t[0];
  const double u = s.dot(p) / det;
  if (u < 0.0 || u > 1.0) return std::nullopt;
  const Vector3 q = s.cross(e1);
  const double v = d.dot(q) / det;
  if (v < 0.0 || u + v > 1.0) return std::nullopt;
  const double fraction = e2.dot(q) / det;
  if (fraction < 0.0 || fraction > 1.0) return std::nullopt;
  return fraction;
}

CollisionMesh::CollisionMesh(const TriangleMesh& mesh) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) throw std::invalid_argument("collision mesh: a vertex is not finite");
    extent_ = std::max(extent_, mesh.vertices[i].norm());
  }
  for (const auto& t : mesh.triangles) {
    for (const auto i : t) {
      if (i >= mesh.vertices.size())
        throw std::invalid_argument("collision mesh: a triangle has no such vertex");
    }
    triangles_.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
    index_.push_back(static_cast<std::uint32_t>(index_.size()));
  }
  if (triangles_.size() >= kBruteForce) {
    nodes_.reserve(2 * triangles_.size());
    build(0, static_cast<std::uint32_t>(triangles_.size()));
    // Lay the triangles out in the tree's order, so that a leaf is one run of memory.
    std::vector<Triangle> ordered;
    ordered.reserve(triangles_.size());
    for (const auto i : index_) ordered.push_back(triangles_[i]);
    triangles_ = std::move(ordered);
  }
}

std::uint32_t CollisionMesh::build(std::uint32_t first, std::uint32_t last) {
  Node node;
  node.box = {Vector3::Constant(std::numeric_limits<double>::infinity()),
              Vector3::Constant(-std::numeric_limits<double>::infinity())};
  Box centres = node.box;
  const auto centre = [&](std::uint32_t i) {
    const auto& t = triangles_[i];
    return Vector3((t[0] + t[1] + t[2]) / 3.0);
  };
  for (std::uint32_t i = first; i < last; ++i) {
    for (const auto& v : triangles_[index_[i]]) {
      node.box.low = node.box.low.cwiseMin(v);
      node.box.high = node.box.high.cwiseMax(v);
    }
    centres.low = centres.low.cwiseMin(centre(index_[i]));
    centres.high = centres.high.cwiseMax(centre(index_[i]));
  }
  const auto self = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back(node);
  if (last - first <= kLeaf) {
    nodes_[self].first = first;
    nodes_[self].count = last - first;
    return self;
  }
  Eigen::Index axis = 0;
  (centres.high - centres.low).maxCoeff(&axis);
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(index_.begin() + first, index_.begin() + middle, index_.begin() + last,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double x = centre(a)[axis], y = centre(b)[axis];
                     return x < y || (x == y && a < b);  // a strict order: the same tree on every library
                   });
  const auto left = build(first, middle);
  const auto right = build(middle, last);
  nodes_[self].left = left;
  nodes_[self].right = right;
  return self;
}

// Calls test(i) for every triangle whose box the path, grown by `margin`, may meet.
template <typename Test>
void CollisionMesh::visit(const Vector3& from, const Vector3& to, double margin, Test&& test) const {
  if (nodes_.empty()) {
    for (std::uint32_t i = 0; i < triangles_.size(); ++i) test(i);
    return;
  }
  const Vector3 low = from.cwiseMin(to).array() - margin, high = from.cwiseMax(to).array() + margin;
  std::array<std::uint32_t, 64> stack;  // a median split of 2^32 triangles is 32 deep
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const Node& node = nodes_[stack[--depth]];
    if ((node.box.low.array() > high.array()).any() || (node.box.high.array() < low.array()).any()) continue;
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) test(i);
    } else {
      stack[depth++] = node.left;
      stack[depth++] = node.right;
    }
  }
}

std::optional<SweepHit> CollisionMesh::sweep(const Vector3& from, const Vector3& to, double radius) const {
  std::optional<SweepHit> best;
  visit(from, to, radius, [&](std::uint32_t i) {
    auto hit = sweep_sphere(triangles_[i], from, to, radius);
    if (!hit) return;
    hit->triangle = index_[i];
    const auto deeper = [&] {  // of two overlaps at the start the deeper one shows the way out
      return (from - hit->point).squaredNorm() < (from - best->point).squaredNorm();
    };
    if (!best || hit->fraction < best->fraction ||
        (hit->overlapped && best->overlapped
             ? deeper()
             : hit->fraction == best->fraction && hit->triangle < best->triangle)) {
      best = hit;
    }
  });
  return best;
}

void CollisionMesh::in_box(const Vector3& low, const Vector3& high,
                           std::vector<std::uint32_t>& places) const {
  places.clear();
  visit(low, high, 0.0, [&](std::uint32_t i) {
    const auto& t = triangles_[i];
    if ((t[0].cwiseMin(t[1]).cwiseMin(t[2]).array() <= high.array()).all() &&
        (t[0].cwiseMax(t[1]).cwiseMax(t[2]).array() >= low.array()).all())
      places.push_back(i);
  });
}

std::optional<SweepHit> CollisionMesh::ray(const Vector3& from, const Vector3& to) const {
  std::optional<SweepHit> best;
  visit(from, to, 0.0, [&](std::uint32_t i) {
    const auto fraction = ray_triangle(triangles_[i], from, to);
    if (!fraction || (best && *fraction >= best->fraction)) return;
    const auto& t = triangles_[i];
    const Vector3 n = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    best = SweepHit{*fraction, n.dot(to - from) > 0.0 ? Vector3(-n) : n, from + *fraction * (to - from),
                    index_[i], false};
  });
  return best;
}

}  // namespace palpate
