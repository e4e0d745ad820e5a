// The timestamp latch that Aravis' pretended camera lacks: a client that writes GevTimestampControl makes it read its clock, and
// finds the reading in GevTimestampValue, as GigE Vision has it.
//
// It stands before a function of the library (fake_camera_clock.cpp is linked into whoever pretends a camera), so the question
// comes over the network like any other. For one camera in a process; set before there is one.
#pragma once

#include <cstdint>
#include <functional>

namespace palpate {

// Of the camera's thread; ns. CLOCK_REALTIME unless it is set; empty: the camera has no latch.
void set_fake_camera_clock(std::function<std::uint64_t()> clock);

}  // namespace palpate
