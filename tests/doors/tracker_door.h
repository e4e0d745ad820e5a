// The laboratory's tracker as an OpenIGTLink server: what an optical tracker's own program would send of its tools.
//
// A TRANSFORM for each tool that was seen, named MARKERToWorld, World the tracker's own frame; metres here, millimetres
// on the wire. Its stamps are the tracker's, from a start of their own, since the protocol knows none below 0. A tool
// that was not seen is not sent. Serves 127.0.0.1 alone.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "drivers/laboratory/channel.h"

namespace palpate::doors {

// Until `stop`, or until the laboratory is gone, which is no error. `ready` is called once it listens.
Expected<void> serve_tracker(const std::shared_ptr<drivers::laboratory::LabClient>& laboratory,
                             std::uint16_t port, const std::atomic<bool>& stop, void (*ready)());

}  // namespace palpate::doors
