// What the physics server's loops were given and did, as messages of palpate_recording.proto. Pure. decode() checks what it reads as
// any file of others: counts, finite numbers, enumerations; a message that is none is refused, with the reason.
#pragma once

#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/record/session/physics_ticks.h"

namespace palpate::record::session {

std::string encode_sample(const RecordedHapticTick& tick);  // palpate.recording.ArmSample
std::string encode_force(const haptics::HapticTick& tick);  // palpate.recording.ArmForce
std::string encode_step(const RecordedStep& step);  // palpate.recording.PhysicsStep; without its state

// What an ArmSample holds of a tick.
Expected<RecordedHapticTick> decode_sample(std::string_view bytes);
// What an ArmForce holds is put in `tick`.
Expected<void> decode_force(std::string_view bytes, haptics::HapticTick& tick);
Expected<RecordedStep> decode_step(std::string_view bytes);

}  // namespace palpate::record::session
