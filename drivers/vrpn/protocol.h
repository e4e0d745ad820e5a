// VRPN over drivers/network: as a client of its servers, and as a server of poses.
#pragma once

#include <memory>

#include "drivers/network/pose_client.h"
#include "drivers/network/pose_server.h"

namespace palpate::drivers::vrpn {

inline constexpr network::Protocol kProtocol{"VRPN", "a VRPN server", "vrpn://", 3883};

// Every tracker pose that the server sends: the tool is the device's name, for sensors beyond the first with the sensor's
// number ("Tracker0:2", codec.h). Over TCP alone: what a server would rather send by UDP comes the same way, and none is lost.
Expected<std::unique_ptr<network::PoseClient>> connect(const network::Address& server);

// Each tool is a device of its name with one sensor. Clients may connect by TCP ("tcp://HOST" in their address), or as
// they do by themselves: they send a datagram to the same port and are connected to. Only the machine that asked is.
Expected<std::unique_ptr<network::PoseServer>> listen(const network::Address& address,
                                                      const network::PoseServerOptions& options = {});

}  // namespace palpate::drivers::vrpn
