// The options by which every client of a physics server is told where it is.
#pragma once

#include <CLI/CLI.hpp>

#include "palpate/transport/server_place.h"

namespace palpate::tools::commands {

inline void add_server_options(CLI::App& command, transport::ServerName& name) {
  command.add_option("--connect", name.address,
                     "ZeroMQ address of the physics server; the default is this user's private socket");
  command.add_option("--keys", name.keys, "Folder of keys for tcp://; see palpate keys");
  command.add_option("--server-key", name.server_key,
                     "Public key of the physics server; without, the one entered with palpate keys trust");
  command.add_flag("--insecure", name.insecure, "Use tcp:// without keys");
}

}  // namespace palpate::tools::commands
