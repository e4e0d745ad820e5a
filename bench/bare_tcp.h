// Bare TCP with Nagle off, one thread on each side that blocks: what every exchange stands on.
#pragma once

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace palpate::bare_tcp {

inline bool transfer_all(int fd, std::vector<char>& buffer, bool out) {
  for (std::size_t done = 0; done < buffer.size();) {
    const ssize_t n = out ? ::send(fd, buffer.data() + done, buffer.size() - done, MSG_NOSIGNAL)
                          : ::recv(fd, buffer.data() + done, buffer.size() - done, 0);
    if (n <= 0) return false;
    done += static_cast<std::size_t>(n);
  }
  return true;
}

inline void no_delay(int fd) {
  const int one = 1;
  ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
}

// Each request's first eight bytes say how long the reply is to be.
inline void echo(int listener, std::size_t request_bytes) {
  const int peer = ::accept(listener, nullptr, nullptr);
  no_delay(peer);
  std::vector<char> request(request_bytes), reply;
  while (transfer_all(peer, request, false)) {
    std::uint64_t size = 0;
    std::copy_n(request.data(), sizeof size, reinterpret_cast<char*>(&size));
    reply.resize(size);
    if (!transfer_all(peer, reply, true)) break;
  }
  ::close(peer);
}

inline int listen_somewhere(sockaddr_in& address) {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  if (::bind(listener, generic, size) != 0 || ::listen(listener, 1) != 0)
    throw std::runtime_error("no TCP port");
  ::getsockname(listener, generic, &size);
  return listener;
}

}  // namespace palpate::bare_tcp
