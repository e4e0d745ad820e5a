#include "palpate/transport/wire_numbers.h"

#include "palpate/transport/internal/wire_forces.h"
#include "palpate/transport/internal/wire_health.h"

namespace palpate::transport {

int wire_number(device::ForceState state) { return to_wire(kWireForceStates, state); }
int wire_number(device::ForceFault fault) { return to_wire(kWireForceFaults, fault); }
int wire_number(device::HealthCode code) { return to_wire(kWireHealthCodes, code); }
int wire_number(scene::Control control) { return static_cast<int>(control); }

std::optional<device::ForceState> force_state_of(int number) { return from_wire(kWireForceStates, number); }
std::optional<device::ForceFault> force_fault_of(int number) { return from_wire(kWireForceFaults, number); }
std::optional<device::HealthCode> health_code_of(int number) { return from_wire(kWireHealthCodes, number); }
std::optional<scene::Control> control_of(int number) {
  if (!wire::Control_IsValid(number)) return std::nullopt;
  return static_cast<scene::Control>(number);
}

}  // namespace palpate::transport
