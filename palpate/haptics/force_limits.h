// What a haptic arm and the hand on it may be given: a device's limits, and how forces come and go.
//
// N, s, m, rad. Values; check_force_limits() throws std::invalid_argument for limits that cannot be kept.
// Defaults are those of a PHANToM Premium 1.5: the makers' 8.5 N peak and 1.4 N continuous; the slew lies
// below the 4 N per millisecond at which such devices switch themselves off. Formulas: docs/theory/forces.md.
#pragma once

#include <array>
#include <limits>
#include <string_view>

#include "palpate/device/arm_model.h"
#include "palpate/device/opened.h"

namespace palpate::haptics {

struct ForceLimits {
  double peak_n = 8.5;
  double continuous_n = 1.4;  // root mean square over `continuous_s` stays below (motor_heat.h)
  double continuous_s = 1.0;  // time constant of that mean, 0.5 ... 100 s
  double slew_n_s = 3000.0;   // 3 N per millisecond
  double start_ramp_s = 1.0;  // from 0 to full strength, also after a fault
  double fade_s = 0.015;      // from full strength to 0 in a fault; with stale_s: 20 ms after the last input
  double max_tip_speed_m_s = 3.0;  // faster: off until rearm()
  double stale_s = 0.005;          // no fresh input, reading or tick for this long: fade
  double max_backlog_s = 0.100;    // what is left of an impact's impulse this long after it ended is given up
  double most_damping_n_s_m = 2.0;  // that the passivity observer may inject; 0 switches it off
  // Corrected joint angles, rad, or stated places of a Cartesian arm, m, within which forces are rendered: the
  // arm's stated range and a little more.
  std::array<std::array<double, 2>, device::kMostJoints> joint_range = premium_range();

  static constexpr std::array<std::array<double, 2>, device::kMostJoints> any_range() {
    std::array<std::array<double, 2>, device::kMostJoints> range{};
    constexpr double kAny = std::numeric_limits<double>::infinity();
    for (auto& joint : range) joint = {-kAny, kAny};
    return range;
  }
  static constexpr std::array<std::array<double, 2>, device::kMostJoints> premium_range() {
    auto range = any_range();
    range[0] = {-1.6, 1.6};
    range[1] = {-1.0, 2.1};
    range[2] = {-1.6, 1.6};
    return range;
  }
};

// Of the arm model a rig names; a mouse moves a computed Premium 1.5, and the laboratory's delta has the same motors. A model nobody has told us about gets
// the weakest limits of the table.
ForceLimits force_limits_of(std::string_view arm_model);
// The same with the joints' ranges where the arm is a chain, those that its rows state, or a Cartesian arm.
ForceLimits force_limits_of(const device::ArmModel& arm);

// Those that a device states itself where they are lower.
ForceLimits lowered_to(ForceLimits limits, const device::ArmFacts& device);

void check_force_limits(const ForceLimits& limits);

}  // namespace palpate::haptics
