#include "palpate/transport/internal/server_connection.h"

#include <fcntl.h>
#include <linux/sockios.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <utility>

#include "palpate/core/file_descriptor.h"
#include "palpate/transport/internal/socket_number.h"

namespace palpate::transport::zmq {

void ServerConnection::began(int descriptor) {
  ended();
  descriptor_ = descriptor;
  number_ = number_of(descriptor);
}

void ServerConnection::ended() {
  number_.reset();
  whole_ = 0;
  flood_ = came_ = false;
}

bool ServerConnection::count(std::size_t bytes, Instant<GraphicsClock> now) {
  const std::int64_t window = now.ns() / 100'000'000;
  if (window != window_) messages_ = bytes_ = 0;
  window_ = window;
  ++messages_;
  bytes_ += bytes;
  came_ = true;
  flood_ = flood_ || messages_ > kMostMessages || bytes_ > kMostBytes;
  return !flood_;
}

bool ServerConnection::too_much() {
  if (!there()) return false;
  const auto read = bytes_read();
  if (std::exchange(came_, false)) whole_ = read.value_or(0);
  return flood_ || (read && *read > whole_ + 2 * largest_ + kSlackBytes);
}

// libzmq may close the descriptor at any moment, and another file gets its number: so it is held first, and looked
// at again.
void ServerConnection::end() {
  const FileDescriptor held(fcntl(descriptor_, F_DUPFD_CLOEXEC, 0));
  if (held && number_ && number_of(held.get()) == number_) ::shutdown(held.get(), SHUT_RDWR);
  number_.reset();
}

std::optional<std::uint64_t> ServerConnection::bytes_read() const {
  tcp_info info{};
  socklen_t size = sizeof info;
  int unread = 0;  // by libzmq; first, for more may come
  if (!number_ || ioctl(descriptor_, SIOCINQ, &unread) != 0) return std::nullopt;
  if (getsockopt(descriptor_, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return std::nullopt;
  return info.tcpi_bytes_received - static_cast<std::uint64_t>(unread);
}

}  // namespace palpate::transport::zmq
