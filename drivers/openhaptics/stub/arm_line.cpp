#include "drivers/openhaptics/stub/arm_line.h"

#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace hd_stub {

void ArmLine::hurry() const {
  sched_param first{};
  first.sched_priority = 85;
  if (named()) static_cast<void>(pthread_setschedparam(pthread_self(), SCHED_FIFO, &first));
}

bool ArmLine::reach() {
  const std::lock_guard lock(guard_);
  if (is_open()) return true;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (!named() || std::strlen(path_) >= sizeof address.sun_path) return false;
  std::strcpy(address.sun_path, path_);
  socket_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (is_open() && ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    close();
  return is_open();
}

void ArmLine::close() {
  if (is_open()) ::close(socket_);
  socket_ = -1;
}

bool ArmLine::take(ArmReading& reading, int ms) {
  const std::lock_guard lock(guard_);
  pollfd item{socket_, POLLIN, 0};
  if (!is_open() || ::poll(&item, 1, ms) <= 0) return false;
  for (bool any = false;; any = true) {
    ArmReading next;
    const auto got = ::recv(socket_, &next, sizeof next, MSG_DONTWAIT);
    if (got == static_cast<ssize_t>(sizeof next)) {
      reading = next;
      continue;
    }
    if (got >= 0 || (errno != EAGAIN && errno != EINTR)) close();
    return any;
  }
}

void ArmLine::give(const ArmForce& force) {
  const std::lock_guard lock(guard_);
  if (is_open()) static_cast<void>(::send(socket_, &force, sizeof force, MSG_DONTWAIT | MSG_NOSIGNAL));
}

}  // namespace hd_stub
