// The thread of a headset: reaches the runtime, shows what is handed over at the display's rate, and begins anew when
// the runtime has gone. With OpenXR frame_loop.cpp, without it no_openxr.cpp.
#pragma once

#include <memory>

#include "palpate/headset/internal/shared_state.h"

namespace palpate::headset {

bool openxr_built_in();
// Until state->stopping.
void run_frame_loop(const std::shared_ptr<SharedState>& state);
// Runtime and headset, asked and let go again.
Expected<HeadsetFacts> ask_runtime();

}  // namespace palpate::headset
