// A recording shown again: it answers graphics servers and observers as a physics server does, with the states that were
// recorded, at the pace at which they came. Nobody can tell the difference but by what a wish does: nothing.
//
// Ordinary threads; returns when it is over or somebody asks for the end. Errors: refused where the recording holds no session
// of a physics server, or another server answers there already.
#pragma once

#include <filesystem>
#include <functional>
#include <limits>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/server/physics/serving_place.h"

namespace palpate::server::physics {

struct ShowOptions {
  std::filesystem::path recording;
  ServingPlace place;
  double from_s = 0.0;  // of the recording
  double to_s = std::numeric_limits<double>::infinity();
  double speed = 1.0;           // times as fast as it was
  bool loop = false;            // again and again
  std::function<void()> ready;  // called once, when it answers
};

// {"seconds": of the recording that were shown, "states": .., "requests": ..}
Expected<Json> show_recording(const ShowOptions& options);

}  // namespace palpate::server::physics
