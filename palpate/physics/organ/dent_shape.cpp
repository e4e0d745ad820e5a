#include "palpate/physics/organ/dent_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "palpate/physics/deformable/quadratic_shape.h"
#include "palpate/physics/deformable/site_law.h"
#include "palpate/physics/deformable/tip_contact.h"

namespace palpate::physics::organ {
namespace {

constexpr double kNearProfile = 1.5;  // contact radii, beyond which a series is as good
constexpr double kLeastOwn = 0.2;     // of the depth, that the contact itself has at least
constexpr double kSoft = 0.02;        // of the squared reach: how nearly a blend goes through a site

// Of the triangle's point that is nearest to p: its barycentric coordinates.
deformable::Barycentric3 nearest_in(const std::array<Vector3, 3>& t, const Vector3& p) {
  const Vector3 u = t[1] - t[0], v = t[2] - t[0], w = p - t[0];
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), wu = w.dot(u), wv = w.dot(v);
  const double det = uu * vv - uv * uv, s = (wu * vv - wv * uv) / det, r = (wv * uu - wu * uv) / det;
  if (s >= 0.0 && r >= 0.0 && s + r <= 1.0) return {1.0 - s - r, s, r};
  deformable::Barycentric3 best{};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 &a = t[i], along = t[(i + 1) % 3] - a;
    const double part = std::clamp(along.dot(p - a) / along.squaredNorm(), 0.0, 1.0);
    const double distance2 = (a + part * along - p).squaredNorm();
    if (distance2 >= least) continue;
    least = distance2;
    best = {};
    best[i] = 1.0 - part;
    best[(i + 1) % 3] = part;
  }
  return best;
}

struct Patch {
  std::array<Vector3, 3> corners;
  Vector3 middle;
  double reach;  // from there to the farthest corner
};

std::vector<Patch> patches_of(const deformable::TetMesh& mesh) {
  std::vector<Patch> patches;
  for (const auto& facet : mesh.facets) {
    Patch patch{};
    for (std::size_t k = 0; k < 3; ++k) patch.corners[k] = mesh.nodes[static_cast<std::size_t>(facet[k])];
    patch.middle = (patch.corners[0] + patch.corners[1] + patch.corners[2]) / 3.0;
    for (const Vector3& corner : patch.corners)
      patch.reach = std::max(patch.reach, (corner - patch.middle).norm());
    patches.push_back(patch);
  }
  return patches;
}

Vector3 place_in(const Patch& patch, const deformable::Barycentric3& L) {
  return L[0] * patch.corners[0] + L[1] * patch.corners[1] + L[2] * patch.corners[2];
}

}  // namespace

std::vector<Anchor> anchors_of(const scene::TriangleMesh& surface, const deformable::TetMesh& mesh,
                               const std::vector<int>& surface_nodes) {
  const auto patches = patches_of(mesh);
  std::vector<Anchor> anchors;
  anchors.reserve(surface.vertices.size());
  std::size_t best = 0;
  for (const Vector3& vertex : surface.vertices) {
    // The facet of the vertex before is a good first guess.
    auto L = nearest_in(patches[best].corners, vertex);
    double least = (place_in(patches[best], L) - vertex).norm();
    for (std::size_t f = 0; f < patches.size(); ++f) {
      const double far = least + patches[f].reach;
      if ((patches[f].middle - vertex).squaredNorm() > far * far) continue;
      const auto tried = nearest_in(patches[f].corners, vertex);
      const double distance = (place_in(patches[f], tried) - vertex).norm();
      if (distance < least) least = distance, L = tried, best = f;
    }
    const auto shape = deformable::facet_shape(L);
    Anchor anchor;
    for (std::size_t k = 0; k < 6; ++k) {
      const auto found = std::lower_bound(surface_nodes.begin(), surface_nodes.end(), mesh.facets[best][k]);
      anchor.nodes[k] = static_cast<std::uint32_t>(found - surface_nodes.begin());
      anchor.shares[k] = static_cast<float>(shape(static_cast<Eigen::Index>(k)));
    }
    anchors.push_back(anchor);
  }
  return anchors;
}

double half_space_profile(double s) {
  if (s <= 1.0) return 1.0 - 0.5 * s * s;
  if (s < kNearProfile)
    return ((2.0 - s * s) * std::asin(1.0 / s) + std::sqrt(s * s - 1.0)) / std::numbers::pi;
  // Moments of the pressure about its middle, 2/5, 8/35 and 16/105, times the squares of P_2k(0).
  const double x = 1.0 / (s * s);
  return 4.0 / (3.0 * std::numbers::pi * s) *
         (1.0 + x * (1.0 / 10.0 + x * (9.0 / 280.0 + x * (5.0 / 336.0 + x * 0.00829))));
}

DentShape::DentShape(const scene::TriangleMesh& surface, std::vector<Anchor> anchors, DentTable table,
                     double tip_radius)
    : rest_(surface.vertices),
      anchors_(std::move(anchors)),
      table_(std::move(table)),
      radius_(tip_radius),
      blended_(Eigen::VectorXf::Zero(table_.rest.moved.rows())) {
  const std::size_t sites = table_.sites.size();
  bool fits = anchors_.size() == rest_.size() && sites > 0 && table_.rest.own.size() == sites &&
              static_cast<std::size_t>(table_.rest.moved.cols()) == sites &&
              table_.rest.moved.rows() % 3 == 0 && radius_ > 0.0;
  for (const Anchor& anchor : anchors_)
    for (const std::uint32_t node : anchor.nodes)
      fits = fits && 3 * static_cast<Eigen::Index>(node) < table_.rest.moved.rows();
  if (!fits) throw std::invalid_argument("dent: surface, anchors and tables do not fit one another");
}

// The nearest sites that face the same way, with weights that sum to 1 and are zero where the next would come in.
std::size_t DentShape::near(const Vector3& foot, const Vector3& normal,
                            std::array<Share, kBlended + 1>& found) const {
  const auto nearer = [](const Share& a, const Share& b) { return a.distance2 < b.distance2; };
  std::size_t count = 0;
  for (std::size_t i = 0; i < table_.sites.size(); ++i) {
    // A site that faces elsewhere is farther away than it lies.
    const double away = 1.0 - normal.dot(table_.sites[i].normal);
    const Share share{(table_.sites[i].place - foot).squaredNorm() + away * away * radius_ * radius_, 0.0, i};
    if (count < found.size()) {
      found[count++] = share;
    } else if (nearer(share, found[count - 1])) {
      found[count - 1] = share;
    } else {
      continue;
    }
    for (std::size_t k = count - 1; k > 0 && nearer(found[k], found[k - 1]); --k)
      std::swap(found[k], found[k - 1]);
  }
  const double reach2 = std::max((count <= kBlended ? 2.0 : 1.0) * found[count - 1].distance2, 1e-12);
  if (count > kBlended) --count;
  double sum = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const double q = found[k].distance2 / reach2, fall = std::max(0.0, 1.0 - q);
    sum += found[k].weight = fall * fall * fall / (q + kSoft);
  }
  for (std::size_t k = 0; k < count; ++k)
    found[k].weight = sum > 0.0 ? found[k].weight / sum : 1.0 / static_cast<double>(count);
  return count;
}

void DentShape::press(const Vector3& tip, double depth, const Vector3& force,
                      std::span<Vector3> vertices) const {
  if (vertices.size() != rest_.size())
    throw std::invalid_argument("dent: as many places as vertices are expected");
  std::copy(rest_.begin(), rest_.end(), vertices.begin());
  const double newtons = force.norm();
  if (!(depth > 0.0 && newtons > 0.0 && tip.allFinite() && std::isfinite(newtons))) return;
  const Vector3 normal = force / newtons, foot = tip - (radius_ - depth) * normal;
  std::array<Share, kBlended + 1> found{};
  const std::size_t count = near(foot, normal, found);
  blended_.setZero();
  double own = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto site = found[k].site;
    blended_ += static_cast<float>(newtons * found[k].weight) *
                table_.rest.moved.col(static_cast<Eigen::Index>(site));
    own += newtons * found[k].weight * table_.rest.own[site];
  }
  // What is left of the depth is the contact's own.
  const double delta = std::max(depth - own, kLeastOwn * depth);
  const double per_radius = 1.0 / deformable::footprint(radius_, std::min(delta, 2.0 * radius_));
  const deformable::RigidTip body{tip, normal, radius_};
  const double near2 = 4.0 * radius_ * radius_;
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    const Anchor& anchor = anchors_[i];
    Eigen::Vector3f moved = Eigen::Vector3f::Zero();
    for (std::size_t k = 0; k < 6; ++k)
      moved += anchor.shares[k] * blended_.segment<3>(3 * static_cast<Eigen::Index>(anchor.nodes[k]));
    const double distance = (rest_[i] - foot).norm();
    Vector3 place =
        rest_[i] + moved.cast<double>() - delta * half_space_profile(distance * per_radius) * normal;
    if ((place - tip).squaredNorm() < near2)
      if (const auto inside = deformable::penetration(body, place); inside.depth > 0.0)
        place += inside.depth * inside.normal;
    vertices[i] = place;
  }
}

}  // namespace palpate::physics::organ
