// A delta arm as the laboratory has it: three chains from a base to a plate that stays level, on which the tip sits.
//
// Each chain is an arm of length `upper`, turned by a motor about a horizontal axis, and a parallelogram of rods of length
// `lower`. The device knows its maker's lengths and what its encoders read, and states the place that these make; it turns
// a force into torques by them, too. How it was built and assembled differs. Frames: ArmBase; the base lies `height` above
// its origin and looks down (-y). Metres, radians, newtons. Values; nothing allocates. Source of the mechanism: Clavel
// (1988), "DELTA, a fast robot with parallel geometry".
#pragma once

#include <array>
#include <cstdint>

#include "palpate/math/so3.h"

namespace palpate::sim {

struct DeltaChain {
  double azimuth = 0.0;  // rad, of its plane about the base's axis
  double offset = 0.0;   // m, the base's radius less the plate's
  double upper = 0.0, lower = 0.0;
  double zero = 0.0;  // rad, what its encoder reads too little
};

class DeltaArm {
 public:
  struct Faults {  // one sigma each
    double length = 0.0, azimuth = 0.0, zero = 0.0;
  };

  // As its maker describes it.
  DeltaArm();
  // The same as it was built, drawn for a seed.
  static DeltaArm built(const Faults& faults, std::uint64_t seed);

  // Encoder readings with the tip at `place`, which it has to reach; to the nearest `quantum`.
  Vector3 readings(const Vector3& place, double quantum = 0.0) const;
  // Where the tip is by these readings, near `guess`.
  Vector3 place(const Vector3& readings, const Vector3& guess) const;
  // d place / d readings, with the tip at `place`.
  Matrix3 jacobian(const Vector3& place) const;
  bool reaches(const Vector3& place) const;

  const std::array<DeltaChain, 3>& chains() const { return chains_; }

 private:
  Vector3 in_chains(const Vector3& place) const;  // axes of the mechanism: z down from the base
  std::array<DeltaChain, 3> chains_;
};

}  // namespace palpate::sim
