// Recorded ball flights into the fit of a flight.
#include "fuzz/check.h"
#include "palpate/physics/flight_file.h"

namespace palpate::fuzz {

Refusals flights(std::string_view file) {
  Refusals refusals;
  auto seen = physics::parse_flight(file, "flight.csv");
  if (!answered(seen, refusals)) return refusals;
  cut(*seen);
  physics::BallModel model;
  model.gravity = {0.0, 0.0, -9.81};
  physics::BouncePlane table;
  table.point = {0.0, 0.0, 0.76};
  table.normal = Vector3::UnitZ();
  const auto fit = physics::fit_flight(model, {&table, 1}, *seen);
  if (answered(fit, refusals)) {
    hold_finite(fit->state.position, "a ball's place is finite");
    hold_finite(fit->state.velocity, "a ball's velocity is finite");
    hold_finite(fit->rms, "a fit's misfit is finite");
  }
  return refusals;
}

}  // namespace palpate::fuzz
