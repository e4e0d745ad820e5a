#include "soft_body.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace jelly {
namespace {

using palpate::Vector3;

constexpr double kMass = 0.40;                         // kg, of all of it: water of that volume
constexpr double kToRest = 6.0, kToNeighbours = 24.0;  // N/m, of a vertex
constexpr double kAir = 80.0;                          // N/m: the volume's, as stiff as that altogether
constexpr double kStep_s = 0.0005, kLongest_s = 0.020;
constexpr double kMostNeighbours = 6.0;
constexpr double kWeave_s = 0.0004;   // how fast neighbours calm each other
constexpr double kReach_m = 0.009;    // vertices so far from the ball's axis carry it
constexpr double kWholeWeight = 2.0;  // of the vertices under a ball that is carried altogether

}  // namespace

SoftBody::SoftBody(const Material& material)
    : rest_(mould()),
      edges_(edges_of(rest_)),
      areas_(areas_of(rest_)),
      moved_(kVertices, Vector3::Zero()),
      velocity_(kVertices, Vector3::Zero()),
      force_(kVertices, Vector3::Zero()),
      mass_(kMass / kVertices),
      to_rest_(kToRest * material.firmness),
      to_neighbours_(kToNeighbours * material.firmness) {
  double squares = 0.0;
  for (const Vector3& area : areas_) squares += area.squaredNorm();
  pressure_ = kAir * material.firmness / squares;
  drag_ = 2.0 * material.damping * std::sqrt(to_rest_ * mass_);
  const double stiffest = to_rest_ + 2.0 * kMostNeighbours * to_neighbours_ + kAir * material.firmness;
  if (!(material.firmness > 0.0) || !(material.damping >= 0.0) ||
      !(kStep_s * kStep_s * stiffest / mass_ < 1.5))
    throw std::invalid_argument(
        "a jelly of that firmness is too stiff for its steps; 0.3 to 2.5 is expected");
}

void SoftBody::step(double h, const Contact& contact, const Vector3& force) {
  const double gained = volume_gained();
  for (std::size_t i = 0; i < kRim; ++i)
    force_[i] = -to_rest_ * moved_[i] - drag_ * velocity_[i] - pressure_ * gained * areas_[i];
  for (const auto& [a, b] : edges_) {
    const Vector3 pull = to_neighbours_ * (moved_[b] - moved_[a] + kWeave_s * (velocity_[b] - velocity_[a]));
    force_[a] += pull;
    force_[b] -= pull;
  }
  for (std::size_t k = 0; k < contact.count; ++k) force_[contact.vertices[k]] += contact.weights[k] * force;
  for (std::size_t i = 0; i < kRim; ++i) {
    velocity_[i] += h / mass_ * force_[i];
    moved_[i] += h * velocity_[i];
  }
}

void SoftBody::advance(double dt, const Contact& contact, const Vector3& force) {
  const double all = std::clamp(dt, 0.0, kLongest_s);
  const int steps = static_cast<int>(std::ceil(all / kStep_s));
  for (int i = 0; i < steps; ++i) step(all / steps, contact, force);
}

void SoftBody::come_to_rest() {
  std::fill(moved_.begin(), moved_.end(), Vector3::Zero());
  std::fill(velocity_.begin(), velocity_.end(), Vector3::Zero());
}

void SoftBody::copy_to(Surface& surface) const {
  for (std::size_t i = 0; i < kVertices; ++i) {
    const Vector3 at = place(i);
    surface.places[i] = {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z())};
  }
}

double SoftBody::volume_gained() const {
  double gained = 0.0;
  for (std::size_t i = 0; i < kRim; ++i) gained += areas_[i].dot(moved_[i]);
  return gained;
}

double SoftBody::kinetic_energy() const {
  double energy = 0.0;
  for (const Vector3& v : velocity_) energy += 0.5 * mass_ * v.squaredNorm();
  return energy;
}

// The surface under the ball is the weighted mean of the vertices near its axis: it goes smoothly from one to the next.
Contact meet(const Surface& surface, std::span<const Vector3> facing, const Vector3& tip, double radius) {
  Contact found;
  found.normal = outward(tip);
  double weight = 0.0, height = 0.0;
  for (std::size_t i = 0; i < kVertices && found.count < Contact::kMost; ++i) {
    const Vector3 way = surface.at(i) - tip;
    const double along = way.dot(found.normal), aside = way.squaredNorm() - along * along;
    if (aside >= kReach_m * kReach_m || facing[i].dot(found.normal) < 0.3) continue;
    const double near = 1.0 - aside / (kReach_m * kReach_m);
    found.vertices[found.count] = static_cast<std::uint32_t>(i);
    found.weights[found.count++] = near * near;
    weight += near * near;
    height += near * near * along;
  }
  if (weight <= 0.0) return {};
  for (std::size_t k = 0; k < found.count; ++k) found.weights[k] /= weight;
  found.share = std::min(1.0, weight / kWholeWeight);
  found.depth = std::max(0.0, height / weight + radius);
  return found;
}

}  // namespace jelly
