// The kernel's number of a socket, which no other ever has, as its descriptor's is.
#pragma once

#include <sys/socket.h>

#include <cstdint>
#include <optional>

namespace palpate::transport::zmq {

// None: there is no socket at this descriptor.
inline std::optional<std::uint64_t> number_of(int descriptor) {
  std::uint64_t number = 0;
  socklen_t size = sizeof number;
  if (getsockopt(descriptor, SOL_SOCKET, SO_COOKIE, &number, &size) != 0) return std::nullopt;
  return number;
}

}  // namespace palpate::transport::zmq
