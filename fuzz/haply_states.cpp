// What comes from the service of a Haply arm: read or refused in words, and what is read can be pushed with.
#include <cmath>
#include <string>

#include "drivers/haply/protocol.h"
#include "fuzz/check.h"

namespace palpate::fuzz {

Refusals haply_states(std::string_view file) {
  namespace haply = drivers::haply;
  Refusals refusals;
  const auto state = haply::read_state(file);
  if (!state) {
    hold_one_line(state.error());
    return {state.error().message};
  }
  for (const auto& arm : state->arms) {
    hold(arm.place.allFinite() && (!arm.force || arm.force->allFinite()), "places and forces are numbers");
    hold(!arm.id.empty() && !haply::hello(arm.id).empty(), "an arm that was read can be spoken to");
    if (const auto fine = haply::check_configured(arm); !fine) {
      hold_one_line(fine.error());
      refusals.push_back(fine.error().message);
    }
  }
  for (const auto& grip : state->grips)
    hold(std::abs(grip.orientation.norm() - 1.0) < 1e-9, "turns are turns");
  return refusals;
}

}  // namespace palpate::fuzz
