#include "palpate/haptics/force_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "palpate/rig/rig.h"

namespace palpate::haptics {

ForceLimits force_limits_of(std::string_view arm_model) {
  ForceLimits limits;
  if (arm_model == "phantom-premium-1.5" || arm_model == device::kLaboratoryDelta ||
      arm_model == rig::kMouseArm)
    return limits;
  // The Omni / Touch class, the weakest in common use: 3.3 N, 0.88 N continuous, software limit of 1.2 m/s.
  limits.peak_n = 3.3;
  limits.continuous_n = 0.88;
  limits.max_tip_speed_m_s = 1.2;
  return limits;
}

ForceLimits force_limits_of(const device::ArmModel& arm) {
  ForceLimits limits = force_limits_of(std::string_view(arm.name));
  if (arm.kind == device::ArmModel::Kind::phantom) return limits;
  limits.joint_range = ForceLimits::any_range();
  if (arm.kind == device::ArmModel::Kind::cartesian)
    for (std::size_t i = 0; i < arm.places.size(); ++i)
      limits.joint_range[i] = {arm.places[i].low, arm.places[i].high};
  for (std::size_t j = 0; j < arm.joints.size() && j < limits.joint_range.size(); ++j)
    limits.joint_range[j] = {arm.joints[j].range.low, arm.joints[j].range.high};
  return limits;
}

ForceLimits lowered_to(ForceLimits limits, const device::ArmFacts& device) {
  limits.peak_n = std::min(limits.peak_n, device.peak_n.value_or(limits.peak_n));
  limits.continuous_n = std::min(limits.continuous_n, device.continuous_n.value_or(limits.continuous_n));
  return limits;
}

void check_force_limits(const ForceLimits& limits) {
  const auto demand = [](bool good, const char* name, double value, const char* expected) {
    if (!good)
      throw std::invalid_argument(fmt::format("force limits: {} is {}, expected {}", name, value, expected));
  };
  for (const auto& [name, value] :
       {std::pair{"peak_n", limits.peak_n}, std::pair{"continuous_n", limits.continuous_n},
        std::pair{"slew_n_s", limits.slew_n_s}, std::pair{"fade_s", limits.fade_s},
        std::pair{"max_tip_speed_m_s", limits.max_tip_speed_m_s}, std::pair{"stale_s", limits.stale_s}})
    demand(value > 0.0 && std::isfinite(value), name, value, "a number > 0");
  for (const auto& [name, value] :
       {std::pair{"start_ramp_s", limits.start_ramp_s}, std::pair{"max_backlog_s", limits.max_backlog_s},
        std::pair{"most_damping_n_s_m", limits.most_damping_n_s_m}})
    demand(value >= 0.0 && std::isfinite(value), name, value, "a number >= 0");
  demand(limits.continuous_s >= 0.5 && limits.continuous_s <= 100.0, "continuous_s", limits.continuous_s,
         "0.5 to 100 s");
  demand(limits.slew_n_s * limits.fade_s >= limits.peak_n, "slew_n_s * fade_s",
         limits.slew_n_s * limits.fade_s, "at least peak_n, or forces could not be gone within fade_s");
  for (const auto& [low, high] : limits.joint_range)
    demand(low < high, "joint_range", low, "a lower end below the upper one");
}

}  // namespace palpate::haptics
