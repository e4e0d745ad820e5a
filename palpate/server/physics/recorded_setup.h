// A physics set-up and its arm as the words of a recording, and back: what a session's physics side was made of, apart from
// rig and scene, which are attachments. Pure. Errors: refused where words are missing or make no sense.
#pragma once

#include <cstdint>
#include <optional>

#include "palpate/core/expected.h"
#include "palpate/device/opened.h"
#include "palpate/record/mcap.h"
#include "palpate/server/physics/physics_side.h"

namespace palpate::server::physics {

// The name of the metadata that these words are.
inline constexpr const char* kSetupWords = "palpate.physics";

struct RecordedSetup {
  scene::RunSettings run;
  double physics_hz = 1000.0, haptic_hz = 1000.0;
  bool armed = true;
  Duration extra_force_delay{0};
  device::ArmFacts arm;
  std::optional<device::JointVector> torque_limits;  // of an arm that is commanded by torques, N m
  bool guests_timed = true;                          // what guests took in the haptic tick was measured
};

record::Words words_of(const RecordedSetup& setup);
Expected<RecordedSetup> setup_of(const record::Words& words);

RecordedSetup recorded_setup(const PhysicsSetup& setup, device::OpenedArm& arm, bool guests_timed);

}  // namespace palpate::server::physics
