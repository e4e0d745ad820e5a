#include "drivers/openigtlink/driver.h"

#include "drivers/network/live_tracker.h"
#include "drivers/openigtlink/codec.h"
#include "drivers/openigtlink/protocol.h"

namespace palpate::drivers::openigtlink {

void add_to(device::DriverRegistry& registry) {
  registry.add(network::tracker_driver(kProtocol, kNameBytes, "igtl",
                                       "optical trackers behind an OpenIGTLink server",
                                       [](const network::Address& server) { return connect(server); }));
}

}  // namespace palpate::drivers::openigtlink
