#include "palpate/physics/surface_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {

SurfacePatch::SurfacePatch(const CollisionMesh& mesh, double radius) : mesh_(mesh), radius_(radius) {
  places_.reserve(mesh.size());  // memory that is never touched is never really taken
  faces_.reserve(mesh.size());
}

void SurfacePatch::gather(const Vector3& centre, double reach) {
  centre_ = centre;
  reach_ = reach;
  const Vector3 half = Vector3::Constant(reach + radius_);
  mesh_.in_box(centre - half, centre + half, places_);
  faces_.clear();
  for (const auto place : places_) {
    const Triangle& t = mesh_.at(place);
    Vector3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
    const double area = normal.norm();
    if (area > 0.0) normal /= area;
    const Vector3 middle = (t[0] + t[1] + t[2]) / 3.0;
    const double bound = std::max(
        {(t[0] - middle).squaredNorm(), (t[1] - middle).squaredNorm(), (t[2] - middle).squaredNorm()});
    faces_.push_back({middle, std::sqrt(bound), normal, normal.dot(t[0])});
  }
}

std::optional<SweepHit> SurfacePatch::sweep(const Vector3& from, const Vector3& to) const {
  std::optional<SweepHit> best;
  const double length = (to - from).norm();
  Vector3 end = to;  // nothing behind the first touch matters
  double reach = radius_ + length;
  const auto test = [&](std::size_t i) {
    const Face& face = faces_[i];
    const double near = reach + face.bound;
    if ((face.centre - from).squaredNorm() > near * near) return;
    const double h0 = face.normal.dot(from) - face.offset, h1 = face.normal.dot(end) - face.offset;
    if ((h0 > radius_ && h1 > radius_) || (h0 < -radius_ && h1 < -radius_)) return;
    auto hit = sweep_sphere(mesh_.at(places_[i]), from, to, radius_);
    if (!hit) return;
    hit->triangle = mesh_.number(places_[i]);
    if (best) {
      // Of two overlaps at the start the deeper one shows the way out; equal times are decided by number.
      const bool both = hit->overlapped && best->overlapped;
      const double d = (from - hit->point).squaredNorm(), e = (from - best->point).squaredNorm();
      if (both ? d >= e
               : hit->fraction > best->fraction ||
                     (hit->fraction == best->fraction && hit->triangle > best->triangle))
        return;
    }
    best = hit;
    end = from + hit->fraction * (to - from);
    reach = radius_ + hit->fraction * length;
  };
  // The nearest is the likeliest to be in the way, and once it is known spares most of the others.
  std::size_t nearest = faces_.size();
  double distance = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const double d = (faces_[i].centre - from).squaredNorm();
    if (d >= distance) continue;
    distance = d;
    nearest = i;
  }
  if (nearest < faces_.size()) test(nearest);
  for (std::size_t i = 0; i < faces_.size(); ++i)
    if (i != nearest) test(i);
  return best;
}

}  // namespace palpate
