// Where a server of poses is: HOST:PORT as people type it. Protocols of trackers neither encrypt nor ask who is there, so
// listening is on this machine alone unless it is asked for as insecure. Errors: wrong use.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"

namespace palpate::drivers::network {

struct Address {
  std::string host;
  std::uint16_t port = 0;

  std::string text() const;  // HOST:PORT, [HOST]:PORT for IPv6
};

struct Protocol {
  const char* name;            // "OpenIGTLink"
  const char* server;          // "an OpenIGTLink server"
  const char* scheme;          // "igtl://"
  std::uint16_t default_port;  // where none is said
};

// HOST or HOST:PORT.
Expected<Address> parse_server(std::string_view text, const Protocol& protocol);
// PORT or HOST:PORT, HOST a number of one of this machine's interfaces, localhost, or * for all of them; port
// 0 lets the system choose. Beyond this machine only with `insecure`, which is the option `flag`.
Expected<Address> parse_listen(std::string_view text, const Protocol& protocol, bool insecure = false,
                               std::string_view flag = "--insecure");

}  // namespace palpate::drivers::network
