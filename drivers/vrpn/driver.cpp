#include "drivers/vrpn/driver.h"

#include "drivers/network/live_tracker.h"
#include "drivers/vrpn/codec.h"
#include "drivers/vrpn/protocol.h"

namespace palpate::drivers::vrpn {

void add_to(device::DriverRegistry& registry) {
  registry.add(network::tracker_driver(kProtocol, kMostNameBytes, "vrpn",
                                       "trackers of a hundred kinds behind a VRPN server", connect));
}

}  // namespace palpate::drivers::vrpn
