// By how much a Cartesian arm's stated places are off: a smooth function of the place.
//
// A delta arm, or whatever tells its tip's place and not its joints, computes that place with the maker's
// lengths and zeros. Where its own differ, the place is off by an amount that changes smoothly. Here it is a
// polynomial of second degree without the parts that a motion of the base would do: six strains and, for each of
// the six products of coordinates, a vector. What a delta arm of usual tolerances has beyond the second degree is
// some hundredths of a millimetre (docs/theory/arm.md).
//
// Frames: ArmBase, as the device has it. Metres. Pure functions, safe from any thread; nothing allocates.
#pragma once

#include <array>
#include <string>

#include "palpate/math/pose.h"

namespace palpate::device {

class PlaceCorrection {
 public:
  static constexpr int kTerms = 24;
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  using Basis = Eigen::Matrix<double, 3, kTerms>;

  Vector3 centre = Vector3::Zero();  // of the workspace: nothing is corrected there
  double reach = 0.1;                // m: half of its longest side, at which a term counts in full
  Terms terms = Terms::Zero();       // m

  // What is to be added to the stated place: basis(stated) * terms.
  Vector3 at(const Vector3& stated) const { return basis(stated) * terms; }
  Basis basis(const Vector3& stated) const;
  // d at / d stated.
  Matrix3 slope(const Vector3& stated) const;

  // "strain_xx" ... "strain_yz", "bend_xx_x" ...: which product, and along which axis.
  static const std::array<std::string, kTerms>& names();
};

}  // namespace palpate::device
