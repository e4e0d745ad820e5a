// Where OpenIGTLink servers are: HOST:PORT as people type it. The protocol neither encrypts nor asks who is
// there, so listening is on this machine alone unless it is asked for as insecure. Errors: wrong use.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"

namespace palpate::drivers::openigtlink {

struct Address {
  std::string host;
  std::uint16_t port = 0;

  std::string text() const;  // HOST:PORT, [HOST]:PORT for IPv6
};

// HOST or HOST:PORT; the port is 18944 where none is said.
Expected<Address> parse_server(std::string_view text);
// PORT or HOST:PORT, HOST a number of one of this machine's interfaces, localhost, or * for all of them; port
// 0 lets the system choose. Beyond this machine only with `insecure`, which is the option `flag`.
Expected<Address> parse_listen(std::string_view text, bool insecure = false,
                               std::string_view flag = "--insecure");

}  // namespace palpate::drivers::openigtlink
