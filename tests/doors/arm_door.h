// The laboratory's arm as a device at a cable: its encoders and buttons go out about each millisecond, as they are read,
// and the forces that come back go to its motors (drivers/openhaptics/stub/arm_line.h).
//
// The arm's own stamps stay here, for a device of this kind has none. Whoever is connected commands; where nobody is, the
// force is 0. One at a time.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "drivers/laboratory/channel.h"

namespace palpate::doors {

// Until `stop`, or until the laboratory is gone, which is no error. Replaces what lies at `path`, and removes it at the
// end. `ready` is called once it can be connected to.
Expected<void> serve_arm(const std::shared_ptr<drivers::laboratory::LabClient>& laboratory,
                         const std::string& path, const std::atomic<bool>& stop, void (*ready)());

}  // namespace palpate::doors
