#include "drivers/network/socket.h"

#include <netdb.h>
#include <netinet/tcp.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "palpate/core/system_error.h"
#include "palpate/core/text.h"

namespace palpate::drivers::network {
namespace {

// A peer whose machine is gone says nothing; it is noticed after this long, and no sooner where it only works
// hard: 3D Slicer takes nothing from its socket while it loads a large image.
constexpr int kDeadAfterMs = 30'000;
constexpr int kKeepAliveSeconds = 5;
// What lies in the kernel is out of our hands: newer poses could not overtake it.
constexpr int kSendBufferBytes = 64 * 1024;

void set_option(int fd, int level, int option, int value) {
  // None of them is needed for correct results; a system without one goes without.
  static_cast<void>(::setsockopt(fd, level, option, &value, sizeof value));
}

void set_up(int fd) {
  set_option(fd, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(fd, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(fd, IPPROTO_TCP, TCP_KEEPIDLE, kKeepAliveSeconds);
  set_option(fd, IPPROTO_TCP, TCP_KEEPINTVL, kKeepAliveSeconds);
  set_option(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, kDeadAfterMs);
  set_option(fd, SOL_SOCKET, SO_SNDBUF, kSendBufferBytes);
}

}  // namespace

Expected<Wake> Wake::make() {
  FileDescriptor fd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!fd) return refused("no event to be had ({})", reason_of(errno));
  return Wake(std::move(fd));
}
void Wake::set() {
  const std::uint64_t one = 1;
  // Fails only when the counter is full, and then it is set.
  static_cast<void>(!::write(fd_.get(), &one, sizeof one));
}
void Wake::clear() {
  std::uint64_t count = 0;
  static_cast<void>(!::read(fd_.get(), &count, sizeof count));
}

Expected<std::vector<SocketAddress>> resolve(const Address& address) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int code = ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
  if (code != 0)
    return wrong_use("{}: no machine of that name is known ({}); check the host in HOST:PORT",
                     excerpt(address.text(), 100), ::gai_strerror(code));
  std::vector<SocketAddress> all;
  for (const addrinfo* at = found; at != nullptr; at = at->ai_next) {
    SocketAddress& one = all.emplace_back();
    one.size = at->ai_addrlen;
    std::memcpy(&one.storage, at->ai_addr, at->ai_addrlen);
  }
  ::freeaddrinfo(found);
  return all;
}

FileDescriptor begin_connect(const SocketAddress& to) {
  FileDescriptor fd(::socket(to.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!fd) return fd;
  set_up(fd.get());
  if (::connect(fd.get(), reinterpret_cast<const sockaddr*>(&to.storage), to.size) != 0 &&
      errno != EINPROGRESS)
    return FileDescriptor();
  return fd;
}

bool connected(const FileDescriptor& socket) {
  int error = 0;
  socklen_t size = sizeof error;
  if (::getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &error, &size) != 0 || error != 0) return false;
  SocketAddress own, peer;
  own.size = peer.size = sizeof own.storage;
  if (::getpeername(socket.get(), reinterpret_cast<sockaddr*>(&peer.storage), &peer.size) != 0) return false;
  // A free port among those that the system hands out can be connected to itself, and keeps its server away.
  return ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&own.storage), &own.size) != 0 ||
         own.size != peer.size || std::memcmp(&own.storage, &peer.storage, own.size) != 0;
}

Expected<Listening> listen_at(const Address& address) {
  const auto where = resolve(address);
  if (!where) return tl::unexpected(where.error());
  SocketAddress at = where->front();
  Listening listening{
      FileDescriptor(::socket(at.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)), address};
  const int fd = listening.socket.get();
  if (fd >= 0) set_option(fd, SOL_SOCKET, SO_REUSEADDR, 1);
  constexpr int kWaiting = 16;
  if (fd < 0 || ::bind(fd, reinterpret_cast<const sockaddr*>(&at.storage), at.size) != 0 ||
      ::listen(fd, kWaiting) != 0)
    return refused("{}: cannot be listened at ({}); stop the other server or choose another port",
                   address.text(), reason_of(errno));
  at.size = sizeof at.storage;
  if (::getsockname(fd, reinterpret_cast<sockaddr*>(&at.storage), &at.size) == 0)
    listening.address.port = ntohs(at.storage.ss_family == AF_INET
                                       ? reinterpret_cast<const sockaddr_in*>(&at.storage)->sin_port
                                       : reinterpret_cast<const sockaddr_in6*>(&at.storage)->sin6_port);
  return listening;
}

FileDescriptor accept_from(const FileDescriptor& listening) {
  FileDescriptor client(::accept4(listening.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (client) set_up(client.get());
  return client;
}

}  // namespace palpate::drivers::network
