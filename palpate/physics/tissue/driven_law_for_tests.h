// A law that is driven by hand over a block's top, for tests.
#pragma once

#include <algorithm>
#include <cmath>

#include "palpate/physics/tissue/tissue_for_tests.h"
#include "palpate/physics/tissue/tissue_law.h"

namespace palpate::physics::tissue {

inline constexpr double kTop = 0.02, kTipRadius = 0.008;
inline const Pose<World, Body> kAtRest;

inline const TipField& soft_field() {
  static const TipField field = *block_for_tests({});
  return field;
}
// As stiff as is allowed; the box's corners, which are stiffer by the lattice, set that.
inline const TipField& stiff_field() {
  static const TipField field = [] {
    const double rough = soft_field().facts().stiffest_n_m;
    return *block_for_tests({.young = 6000.0 * 0.999 * kMostTangent_n_m / rough});
  }();
  return field;
}

// As stiff as is allowed above something hard, twice as stiff as beside it.
inline const TipField& nodule_field() {
  static const TipField field = [] {
    const auto built = [](double young) {
      return *block_for_tests({.young = young, .share = bump_for_tests({0.003, 0.002, kTop}, 1.0, 0.008)});
    };
    return built(6000.0 * 0.999 * kMostTangent_n_m / built(6000.0).facts().stiffest_n_m);
  }();
  return field;
}

inline Vector3 over(double depth, double x = 0.003, double y = 0.002) {
  return {x, y, kTop + kTipRadius - depth};
}

// What the law has been told last, and its static force there.
struct DrivenLaw {
  explicit DrivenLaw(const TipField& field, const TissueSettings& settings = {})
      : law(field, settings, kAtRest) {}
  Vector3 at(const Vector3& place, const Vector3& velocity = Vector3::Zero()) {
    tip.time += Duration(1'000'000);
    tip.X_world_tip.translation = place;
    tip.velocity = velocity;
    return law.force(tip, 1e-3);
  }
  // In a straight line, so far a tick.
  Vector3 go(const Vector3& to, double step = 1e-5) {
    const Vector3 from = tip.X_world_tip.translation;
    const int ticks = std::max(1, static_cast<int>(std::ceil((to - from).norm() / step)));
    Vector3 force;
    for (int i = 1; i <= ticks; ++i) force = at(from + (to - from) * i / ticks, (to - from) / ticks / 1e-3);
    return force;
  }
  TissueLaw law;
  scene::TipState tip;
};

}  // namespace palpate::physics::tissue
