// Forces on a flat block of soft matter with a ball hidden in it: what the trainee of the study feels.
//
// The block of the reference tables (docs/theory/deformable.md): 106 x 106 x 50 mm, tip of 8 mm, matter of an organ, bonded
// to its table. Neo-Hookean matter is the law of the haptic tick at a place of its surface; linear matter is the
// finite-element solution of small strains, for there is no tick of it. SI; z downwards is depth. Values; the solvers take
// seconds each, any thread. Errors: those of the solvers, in words.
#pragma once

#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::applications::palpation {

inline constexpr double kBlockTip_m = 0.008, kBlockPress_m = 0.005;

struct BlockNodule {
  double diameter = 0.015, top = 0.005;  // m; top: from the surface to it
  double ratio = 10.0;                   // of its Young's modulus to the block's
};

enum class BlockMatter { neo_hookean, linear };

// Force over depth: what is tabulated is F / d^1.5, which is nearly constant; held beyond both ends.
class ForceCurve {
 public:
  // At rising depths above 0; forces above 0. Throws std::invalid_argument for others.
  ForceCurve(std::vector<double> depths, const std::vector<double>& forces);
  // Between two curves of the same depths: the logarithm of the force, `share` of the way from the first to the second.
  static ForceCurve between(const ForceCurve& first, const ForceCurve& second, double share);

  ForceCurve times(double ratio) const;  // of matter so many times as stiff

  double at(double depth) const;  // N; 0 where it is not pressed
  double log_at(double depth) const;

 private:
  ForceCurve() = default;
  std::vector<double> depths_, log_stiffness_;
};

// Pressed in the middle of its top: first without a nodule, then above each of them. `done` hears how many there are; may be
// empty.
Expected<std::vector<ForceCurve>> forces_on_block(std::span<const BlockNodule> nodules, BlockMatter matter,
                                                  const std::function<void(std::size_t)>& done = {});

// The logarithm of the force of a press of kBlockPress_m above that of the same block without a nodule, over how far beside
// the nodule's middle it is pressed.
class ContrastProfile {
 public:
  static constexpr double kStep_m = 0.004;
  // Not negative, at 0, `step`, 2 `step`, ... beside; beyond the last one it fades to 0 at twice as far.
  explicit ContrastProfile(std::vector<double> contrasts, double step = kStep_m)
      : contrasts_(std::move(contrasts)), step_(step) {}
  double at(double beside) const;
  const std::vector<double>& contrasts() const { return contrasts_; }

 private:
  double node(int k) const;

  std::vector<double> contrasts_;
  double step_;  // m
};

// Of one nodule after the other. `done` as above.
Expected<std::vector<ContrastProfile>> contrast_profiles(std::span<const BlockNodule> nodules, int steps,
                                                         const std::function<void(std::size_t)>& done = {});

}  // namespace palpate::applications::palpation
