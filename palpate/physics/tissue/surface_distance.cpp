#include "palpate/physics/tissue/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace palpate::physics::tissue {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

// Vertices at one place are one vertex: which one each is.
std::vector<std::uint32_t> welded(const scene::TriangleMesh& mesh) {
  std::map<std::array<double, 3>, std::uint32_t> known;
  std::vector<std::uint32_t> one;
  for (const Vector3& v : mesh.vertices)
    one.push_back(
        known.try_emplace({v.x(), v.y(), v.z()}, static_cast<std::uint32_t>(one.size())).first->second);
  return one;
}

// The nearest point of a triangle, and where it lies: in the face, on edge 0, 1, 2 or at corner 0, 1, 2.
enum class Where { face, edge, corner };
struct Nearest {
  Vector3 point;
  Where where;
  std::size_t number;
};

Nearest nearest_of(const Triangle& t, const Vector3& p) {
  const Vector3 ab = t[1] - t[0], ac = t[2] - t[0];
  const Vector3 n = ab.cross(ac), ap = p - t[0];
  const double area2 = n.squaredNorm();
  const double v = ap.cross(ac).dot(n), w = ab.cross(ap).dot(n);
  if (v > 0.0 && w > 0.0 && v + w < area2) return {t[0] + (v * ab + w * ac) / area2, Where::face, 0};
  Nearest best{t[0], Where::corner, 0};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 &a = t[i], along = t[(i + 1) % 3] - a;
    const double s = along.dot(p - a) / along.squaredNorm();
    Nearest near{a, Where::corner, i};
    if (s >= 1.0) near = {t[(i + 1) % 3], Where::corner, (i + 1) % 3};
    if (s > 0.0 && s < 1.0) near = {a + s * along, Where::edge, i};
    const double distance2 = (p - near.point).squaredNorm();
    if (distance2 < least) {
      least = distance2;
      best = near;
    }
  }
  return best;
}

}  // namespace

Expected<SurfaceDistance> SurfaceDistance::of(const scene::TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return refused("surface: no triangles; a closed surface is expected");
  for (const Vector3& v : mesh.vertices)
    if (!v.allFinite()) return refused("surface: a vertex is not finite");
  const std::vector<std::uint32_t> one = welded(mesh);
  std::map<Edge, Vector3> along;  // the normal of the face that has this edge in this direction
  std::vector<Vector3> around(mesh.vertices.size(), Vector3::Zero());
  SurfaceDistance surface;
  std::vector<std::array<std::uint32_t, 3>> corners;
  for (const auto& t : mesh.triangles) {
    std::array<std::uint32_t, 3> c{};
    Face face{};
    for (std::size_t i = 0; i < 3; ++i) {
      if (t[i] >= mesh.vertices.size())
        return refused("surface: a triangle names vertex {}, of {}", t[i], mesh.vertices.size());
      c[i] = one[t[i]];
      face.corners[i] = mesh.vertices[t[i]];
    }
    const Vector3 n = (face.corners[1] - face.corners[0]).cross(face.corners[2] - face.corners[0]);
    if (!(n.norm() > 0.0)) return refused("surface: a triangle has no area; repair the mesh");
    face.normal = n.normalized();
    for (std::size_t i = 0; i < 3; ++i) {
      if (!along.try_emplace({c[i], c[(i + 1) % 3]}, face.normal).second)
        return refused(
            "surface: two triangles run along one edge the same way; a closed surface, all of it seen from "
            "outside, is expected: repair the mesh");
      const Vector3 to = (face.corners[(i + 1) % 3] - face.corners[i]).normalized();
      const Vector3 from = (face.corners[(i + 2) % 3] - face.corners[i]).normalized();
      around[c[i]] += std::acos(std::clamp(to.dot(from), -1.0, 1.0)) * face.normal;
    }
    surface.faces_.push_back(face);
    corners.push_back(c);
  }
  for (std::size_t f = 0; f < corners.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto other = along.find({corners[f][(i + 1) % 3], corners[f][i]});
      if (other == along.end())
        return refused(
            "surface: an edge has a triangle on one side only; a closed surface is expected: close its "
            "holes");
      surface.faces_[f].edge_normals[i] = surface.faces_[f].normal + other->second;
      surface.faces_[f].corner_normals[i] = around[corners[f][i]];
    }
  surface.nodes_.reserve(surface.faces_.size());
  surface.build(0, static_cast<std::uint32_t>(surface.faces_.size()));
  return surface;
}

// Halves along the longest side, in the order of the faces' middles.
std::uint32_t SurfaceDistance::build(std::uint32_t first, std::uint32_t last) {
  const auto self = static_cast<std::uint32_t>(nodes_.size());
  Node node;
  node.box = {faces_[first].corners[0], faces_[first].corners[0]};
  for (std::uint32_t f = first; f < last; ++f)
    for (const Vector3& corner : faces_[f].corners)
      node.box = {node.box.low.cwiseMin(corner), node.box.high.cwiseMax(corner)};
  nodes_.push_back(node);
  if (last - first <= kLeaf) {
    nodes_[self].first = first;
    nodes_[self].count = last - first;
    return self;
  }
  Eigen::Index axis = 0;
  (node.box.high - node.box.low).maxCoeff(&axis);
  const std::uint32_t middle = first + (last - first) / 2;
  const auto begin = faces_.begin();
  std::nth_element(begin + first, begin + middle, begin + last, [&](const Face& a, const Face& b) {
    return a.corners[0][axis] + a.corners[1][axis] + a.corners[2][axis] <
           b.corners[0][axis] + b.corners[1][axis] + b.corners[2][axis];
  });
  build(first, middle);
  nodes_[self].first = build(middle, last);
  return self;
}

SurfacePlace SurfaceDistance::at(const Vector3& p, double most) const {
  double best = most * most;
  const Face* face = nullptr;
  Nearest nearest{p, Where::face, 0};
  std::array<std::pair<double, std::uint32_t>, kStack> waiting;
  std::size_t depth = 0;
  waiting[depth++] = {0.0, 0};
  while (depth > 0) {
    const auto [apart, number] = waiting[--depth];
    if (apart >= best) continue;
    const Node& node = nodes_[number];
    for (std::uint32_t f = node.first; f < node.first + node.count; ++f) {
      const Nearest found = nearest_of(faces_[f].corners, p);
      const double distance2 = (p - found.point).squaredNorm();
      if (distance2 >= best) continue;
      best = distance2;
      face = &faces_[f];
      nearest = found;
    }
    if (node.count > 0) continue;
    std::pair near{nodes_[number + 1].box.distance2(p), number + 1};
    std::pair far{nodes_[node.first].box.distance2(p), node.first};
    if (far < near) std::swap(near, far);
    waiting[depth++] = far;
    waiting[depth++] = near;
  }
  if (face == nullptr) return {most, p, Vector3::UnitZ()};
  const Vector3& normal = nearest.where == Where::face   ? face->normal
                          : nearest.where == Where::edge ? face->edge_normals[nearest.number]
                                                         : face->corner_normals[nearest.number];
  const double side = normal.dot(p - nearest.point) < 0.0 ? -1.0 : 1.0;
  return {side * std::sqrt(best), nearest.point, normal.normalized()};
}

}  // namespace palpate::physics::tissue
