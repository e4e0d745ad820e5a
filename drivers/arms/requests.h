// What drivers ask of the arm of a rig before they open one.
#pragma once

#include "palpate/device/driver_registry.h"

namespace palpate::drivers::arms {

// Refused: the rig's arm has joints, and the one asked for states its place.
inline Expected<void> check_states_place(const device::ArmRequest& request) {
  if (request.nominal.kind == device::ArmModel::Kind::cartesian) return {};
  return refused(
      "{}: states its place, the rig's arm {} its joints; name a rig of this arm (palpate calibrate arm with "
      "an arm "
      "of type \"cartesian\")",
      request.uri, request.nominal.name);
}

}  // namespace palpate::drivers::arms
