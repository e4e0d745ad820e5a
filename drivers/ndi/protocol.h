// NDI trackers (Polaris, Vega, Aurora) over drivers/network: as a client of the combined API, and as a server of poses that
// answers as a device does.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/network/pose_client.h"
#include "drivers/network/pose_server.h"

namespace palpate::drivers::ndi {

inline constexpr network::Protocol kProtocol{"NDI", "an NDI tracker", "ndi://", 8765};
inline constexpr std::size_t kMostNameBytes = 100;  // of a tool, as it is named here
// The most that programs of others hold.
inline constexpr std::size_t kMostServed = 24;

// What a wireless tool is, as its maker's file (.rom) says it.
struct Definition {
  static constexpr std::size_t kMostBytes = 2048;
  std::string tool;  // how it is called here: the file's name without .rom
  std::string bytes;
};

// HOST[:PORT][/FILE[,FILE...]]; a file whose path begins with / has two of them before it.
struct Place {
  std::string server;  // HOST[:PORT]
  std::vector<std::string> files;
};
Place split_place(std::string_view text);
// Wrong use: a file that is none, that is empty or larger than any.
Expected<std::vector<Definition>> read_definitions(const std::vector<std::string>& files);

struct ClientOptions {
  std::vector<Definition> wireless;
};

// Initializes the device, enables all tools that are plugged in and those defined, and asks for their poses without a pause.
// Of a device that knows BX2 stamps are its own; of others they are times of arrival. A tool is called as its definition, its
// part number, its serial number or its handle ("handle 0A"); of tools with the same name later ones have ":2" behind it.
// A connection in which a reply stays away, or an error comes that leaves nothing to be heard, ends and is made again. Wrong
// use: a host nobody knows.
Expected<std::unique_ptr<network::PoseClient>> connect(const network::Address& server,
                                                       const ClientOptions& options = {});

struct ServerOptions {
  network::PoseServerOptions of_any = {};
  std::vector<std::string> tools;  // what is there from the beginning; others are, once they are published
  bool timestamps = true;          // answers BX2, as a Vega does; else as older devices
};

// Each client meets a device of its own that shows the same tools, with a handle for each; a tool's name is its part number
// (its first 20 letters). A tool of which nothing was published for half a second is missing. A wireless tool is the one whose
// name is the part number in the definition that a client writes; where there is none it is never seen. Refused: a port that is
// taken, more tools than kMostServed.
Expected<std::unique_ptr<network::PoseServer>> listen(const network::Address& address,
                                                      const ServerOptions& options = {});

}  // namespace palpate::drivers::ndi
