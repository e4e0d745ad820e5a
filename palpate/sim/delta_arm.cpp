#include "palpate/sim/delta_arm.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/random.h"

namespace palpate::sim {
namespace {

constexpr double kHeight = 0.85, kOffset = 0.12, kUpper = 0.35, kLower = 0.80;  // m

// ArmBase is x right, y up, z towards the person; the mechanism's z looks down, its x right.
Matrix3 base_from_chains() {
  Matrix3 R;
  R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return R;
}

Vector3 outwards(const DeltaChain& chain) { return {std::cos(chain.azimuth), std::sin(chain.azimuth), 0.0}; }

Vector3 elbow(const DeltaChain& chain, double angle) {
  return outwards(chain) * (chain.offset + chain.upper * std::cos(angle)) +
         Vector3(0.0, 0.0, chain.upper * std::sin(angle));
}

// By how much the elbow moves as the motor turns.
Vector3 elbow_rate(const DeltaChain& chain, double angle) {
  return chain.upper * (Vector3(0.0, 0.0, std::cos(angle)) - std::sin(angle) * outwards(chain));
}

// Of the motor's angle with the plate at p: -1 to 1 where the chain reaches it.
double cosine_of_elbow(const DeltaChain& chain, const Vector3& p, double x) {
  const double beside = p.dot(Vector3::UnitZ().cross(outwards(chain)));
  return (x * x + beside * beside + p.z() * p.z() + chain.upper * chain.upper - chain.lower * chain.lower) /
         (2.0 * chain.upper * std::hypot(x, p.z()));
}

double motor_angle(const DeltaChain& chain, const Vector3& p) {
  const double x = p.dot(outwards(chain)) - chain.offset;
  // The elbow outwards.
  return std::atan2(p.z(), x) - std::acos(std::clamp(cosine_of_elbow(chain, p, x), -1.0, 1.0));
}

}  // namespace

DeltaArm::DeltaArm() {
  for (std::size_t i = 0; i < 3; ++i)
    chains_[i] = {2.0 * std::numbers::pi * static_cast<double>(i) / 3.0, kOffset, kUpper, kLower, 0.0};
}

DeltaArm DeltaArm::built(const Faults& faults, std::uint64_t seed) {
  DeltaArm arm;
  Random random(seed, "truth/delta-arm");
  for (auto& chain : arm.chains_) {
    chain.azimuth += random.normal(faults.azimuth);
    chain.offset += random.normal(faults.length);
    chain.upper += random.normal(faults.length);
    chain.lower += random.normal(faults.length);
    chain.zero += random.normal(faults.zero);
  }
  return arm;
}

Vector3 DeltaArm::in_chains(const Vector3& place) const {
  return base_from_chains().transpose() * (place - Vector3(0.0, kHeight, 0.0));
}

bool DeltaArm::reaches(const Vector3& place) const {
  const Vector3 p = in_chains(place);
  for (const auto& chain : chains_)
    if (std::abs(cosine_of_elbow(chain, p, p.dot(outwards(chain)) - chain.offset)) > 1.0) return false;
  return true;
}

Vector3 DeltaArm::readings(const Vector3& place, double quantum) const {
  const Vector3 p = in_chains(place);
  Vector3 psi;
  for (std::size_t i = 0; i < 3; ++i) {
    const double angle = motor_angle(chains_[i], p) - chains_[i].zero;
    psi[static_cast<Eigen::Index>(i)] = quantum > 0.0 ? quantum * std::round(angle / quantum) : angle;
  }
  return psi;
}

// Newton's method: from a place nearby it is exact after a few steps.
Vector3 DeltaArm::place(const Vector3& readings, const Vector3& guess) const {
  constexpr int kSteps = 6;
  Vector3 p = in_chains(guess);
  for (int step = 0; step < kSteps; ++step) {
    Vector3 miss;
    Matrix3 rods;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const Vector3 rod = p - elbow(chains_[i], readings[row] + chains_[i].zero);
      miss[row] = 0.5 * (rod.squaredNorm() - chains_[i].lower * chains_[i].lower);
      rods.row(row) = rod.transpose();
    }
    p -= rods.inverse() * miss;
  }
  return base_from_chains() * p + Vector3(0.0, kHeight, 0.0);
}

// The rods keep their lengths: rod . dp = rod . d elbow, chain by chain.
Matrix3 DeltaArm::jacobian(const Vector3& place) const {
  const Vector3 p = in_chains(place);
  Matrix3 rods, motors = Matrix3::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double angle = motor_angle(chains_[i], p);
    const Vector3 rod = p - elbow(chains_[i], angle);
    rods.row(row) = rod.transpose();
    motors(row, row) = rod.dot(elbow_rate(chains_[i], angle));
  }
  return base_from_chains() * rods.inverse() * motors;
}

}  // namespace palpate::sim
