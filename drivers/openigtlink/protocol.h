// OpenIGTLink over drivers/network: as a client of its servers, and as a server of poses.
#pragma once

#include <memory>

#include "drivers/network/pose_client.h"
#include "drivers/network/pose_server.h"

namespace palpate::drivers::openigtlink {

inline constexpr network::Protocol kProtocol{"OpenIGTLink", "an OpenIGTLink server", "igtl://", 18944};

// Some servers send tracking data only to a client that has asked for it (STT_TDATA).
enum class StartRequest {
  when_silent,  // asks where no pose has come half a second after connecting
  at_once,
  never,
};

struct ClientOptions {
  StartRequest start = StartRequest::when_silent;
  int period_ms = 10;  // asked for: at most a message in this time; 0 = as fast as the server can
};

// Poses of TRANSFORM (the tool is the message's device name, such as "StylusToTracker") and of TDATA (a tool for
// each element).
Expected<std::unique_ptr<network::PoseClient>> connect(const network::Address& server,
                                                       const ClientOptions& options = {});

struct ServerOptions {
  network::PoseServerOptions of_any = {};
  bool tracking_data = false;  // answers STT_TDATA: for live poses, of which only the newest matters
};

// Each pose as a TRANSFORM (header version 1), which 3D Slicer shows as a transform of that name. A client that asks
// for it (STT_TDATA) gets the newest poses of all tools as TDATA instead, at the interval it names, until it has
// enough (STP_TDATA). What else clients send is read and ignored.
Expected<std::unique_ptr<network::PoseServer>> listen(const network::Address& address,
                                                      const ServerOptions& options = {});

}  // namespace palpate::drivers::openigtlink
