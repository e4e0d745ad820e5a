// In place of what needs OpenXR, where that was not found when the program was built.
#include "palpate/headset/internal/frame_loop.h"

namespace palpate::headset {

bool openxr_built_in() { return false; }

void run_frame_loop(const std::shared_ptr<SharedState>&) {}

Expected<HeadsetFacts> ask_runtime() { return refused("headset: this program was built without OpenXR"); }

}  // namespace palpate::headset
