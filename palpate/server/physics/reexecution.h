// A recorded session executed again: what its arm read and what its loops learned goes into the same parts as then, and the forces
// that come out are compared with those that were recorded.
//
// By the same build they are equal to the last bit. What differs tells what has changed: a build, a library, or a recording that
// lacks something. Both loops run in threads of their own and wait for each other's values as they had come
// (palpate/time/input_playback.h); no clock counts. Errors: refused where a recording does not hold what is needed, or the set-up
// cannot be made; a difference is no error but a result.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/scene/application_registry.h"

namespace palpate::server::physics {

struct ReexecutionOptions {
  std::filesystem::path recording;
  scene::ApplicationRegistry applications;
  std::filesystem::path mesh;  // where the scene's lies elsewhere than it did
};

struct Reexecution {
  std::uint64_t ticks = 0, steps = 0;  // executed
  std::uint64_t recorded_ticks = 0, recorded_steps = 0;
  // Of a recording that breaks off: those at its end that took over what is not in it, and are not executed.
  std::uint64_t ticks_beyond = 0, steps_beyond = 0;
  std::uint64_t different_forces = 0, different_states = 0;  // ticks, steps
  double largest_force_difference_n = 0.0;
  // The first that differs, or that cannot be executed, in words with its number; empty: there is none.
  std::string first_difference;
  std::string lost;  // what the recording lacks of itself, in words; empty: it is whole

  bool same() const {
    return first_difference.empty() && ticks + ticks_beyond == recorded_ticks &&
           steps + steps_beyond == recorded_steps && ticks > 0;
  }
};

Json json_of(const Reexecution& result);

Expected<Reexecution> execute_again(const ReexecutionOptions& options);

}  // namespace palpate::server::physics
