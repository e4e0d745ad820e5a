#include "palpate/transport/internal/zmq_connection_guard.h"

#include <dirent.h>
#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "palpate/core/system_error.h"
#include "palpate/time/real_time.h"
#include "palpate/transport/internal/socket_number.h"

namespace palpate::transport::zmq {
namespace {

constexpr int kLookEveryMs = 20;
constexpr Duration kLookForMemoryEvery = std::chrono::seconds(1);

// Host or process at the other end.
std::string source_of(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  auto* peer = reinterpret_cast<sockaddr*>(&address);
  if (getpeername(descriptor, peer, &size) != 0) return "gone";
  if (address.ss_family == AF_UNIX) {
    ucred process{};
    socklen_t length = sizeof process;
    if (getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &process, &length) != 0) return "process";
    return fmt::format("process {}", process.pid);
  }
  std::array<char, NI_MAXHOST> host{};
  if (getnameinfo(peer, size, host.data(), host.size(), nullptr, 0, NI_NUMERICHOST) != 0) return "host";
  return host.data();
}

std::size_t descriptors_in_use() {
  DIR* folder = opendir("/proc/self/fd");
  if (folder == nullptr) return 0;
  std::size_t count = 0;
  while (const dirent* entry = readdir(folder))
    if (entry->d_name[0] != '.') ++count;
  closedir(folder);
  return count - 1;  // the folder's own
}

}  // namespace

Expected<std::unique_ptr<ConnectionGuard>> ConnectionGuard::make(const Clock<PhysicsClock>& clock) {
  auto guard = std::make_unique<ConnectionGuard>(clock);
  if (!guard->spare_) return refused("no descriptor left for connections: {}", reason_of(errno));
  return guard;
}

ConnectionGuard::ConnectionGuard(const Clock<PhysicsClock>& clock)
    : clock_(clock),
      others_(descriptors_in_use()),
      spare_(fcntl(stop_.fd(), F_DUPFD_CLOEXEC, 0)),
      thread_([this] { run(); }) {}

ConnectionGuard::~ConnectionGuard() {
  stop_.set();
  thread_.join();
}

Expected<void> ConnectionGuard::watch(const Socket& listener, const Context& context) {
  auto events = Socket::make(ZMQ_PAIR, context);
  if (!events) return tl::unexpected(events.error());
  // A full queue would make libzmq's own thread wait for this one.
  if (!events->receive_without_bound())
    return refused("ZeroMQ refuses a socket option: {}", reason_of(errno));
  const std::lock_guard lock(mutex_);
  const std::string place = fmt::format("inproc://connections-{}", listeners_);
  // No event of what could not be accepted: without descriptors that is one for each turn of libzmq's thread.
  if (zmq_socket_monitor(listener.get(), place.c_str(), ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED) != 0 ||
      zmq_connect(events->get(), place.c_str()) != 0)
    return refused("ZeroMQ tells nothing of its connections: {}", reason_of(errno));
  watched_.push_back({listeners_++, listener.get(), std::move(*events)});
  return {};
}

void ConnectionGuard::leave(const Socket& listener) {
  constexpr std::chrono::milliseconds kLookAgain{1};
  for (auto waited = kLookAgain; end_all_of(listener.get()) && waited < kLeaveWithin; waited += kLookAgain)
    std::this_thread::sleep_for(kLookAgain);
  zmq_socket_monitor(listener.get(), nullptr, 0);
  const std::lock_guard lock(mutex_);
  watched_.remove_if([&](const Watched& one) { return one.listener == listener.get(); });
}

bool ConnectionGuard::heard(const Sender& sender, bool by_operator) {
  const std::lock_guard lock(mutex_);
  if (connections_.is_of(sender.descriptor, sender.user)) return true;
  take_events();  // its beginning has been told before anything was said
  return connections_.heard(sender.descriptor, sender.user, by_operator);
}

void ConnectionGuard::cut_off(const Sender& sender) {
  const std::lock_guard lock(mutex_);
  take_events();
  if (const auto one = connections_.take(sender.descriptor, sender.user)) end(*one);
}

bool ConnectionGuard::full(const std::string& key) {
  const std::lock_guard lock(mutex_);
  take_events();
  return connections_.full(key);
}

void ConnectionGuard::run() {
  name_and_pin_thread("palpate-guard", -1);
  ask_for_short_turns();
  while (true) {
    std::vector<pollfd> items{{stop_.fd(), POLLIN, 0}};
    {
      const std::lock_guard lock(mutex_);
      for (const Watched& one : watched_) items.push_back({one.events.fd(), POLLIN, 0});
    }
    ::poll(items.data(), items.size(), kLookEveryMs);
    if ((items[0].revents & POLLIN) != 0) return;
    give_back_memory();
    const std::lock_guard lock(mutex_);
    take_events();
    end_what_is_overdue();
  }
}

// A server keeps what is freed (keep_freed_memory()).
void ConnectionGuard::give_back_memory() {
  if (clock_.now() - memory_looked_at_ < kLookForMemoryEvery) return;
  memory_looked_at_ = clock_.now();
  const std::size_t resident = resident_bytes();
  if (resident == 0 || !memory_.has_grown(resident, freed_bytes())) return;
  give_back_freed_memory();
  memory_.was_given_back(resident_bytes(), freed_bytes());
}

// Messages of two frames: the event's number with its descriptor, and where.
void ConnectionGuard::take_events() {
  for (Watched& one : watched_) {
    while (one.events.receive(2, &event_, where_) != Socket::Received::nothing) {
      std::uint16_t kind = 0;
      std::int32_t descriptor = -1;
      if (event_.size() != sizeof kind + sizeof descriptor) continue;
      std::memcpy(&kind, event_.data(), sizeof kind);
      std::memcpy(&descriptor, event_.data() + sizeof kind, sizeof descriptor);
      if (kind == ZMQ_EVENT_DISCONNECTED) connections_.ended(one.number, descriptor);
      if (kind != ZMQ_EVENT_ACCEPTED) continue;
      // It may have ended already; then its end is among the next events.
      if (const auto number = number_of(descriptor))
        connections_.began(one.number, descriptor, *number, source_of(descriptor), clock_.now());
    }
  }
}

// How many connections the descriptors allow. The limit may be changed while the process runs.
std::size_t ConnectionGuard::places() const {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return Connections::kMost;
  const auto all = static_cast<std::size_t>(std::min<rlim_t>(limit.rlim_cur, 1 << 20));
  const std::size_t free = all > others_ ? all - others_ : 0;
  return std::min(Connections::kMost, free - std::min(kDescriptorsLeft, free / 4));
}

void ConnectionGuard::end_what_is_overdue() {
  connections_.set_places(places());
  for (const auto& one : connections_.take_overdue(clock_.now())) end(one);
}

// False: there is none.
bool ConnectionGuard::end_all_of(const void* listener) {
  const std::lock_guard lock(mutex_);
  take_events();
  bool any = false;
  for (const Watched& watched : watched_) {
    if (watched.listener != listener) continue;
    for (const auto& one : connections_.of_listener(watched.number)) {
      end(one);
      any = true;
    }
  }
  return any;
}

// libzmq may close a descriptor at any moment, and the next connection gets its number. So the connection is
// first held at a descriptor of the guard's own, and is shut down only if it is still the one that was meant.
void ConnectionGuard::end(const Connections::Ended& one) {
  if (dup3(one.descriptor, spare_.get(), O_CLOEXEC) < 0) return;
  if (number_of(spare_.get()) == one.number) shutdown(spare_.get(), SHUT_RDWR);  // or it has closed just now
  dup3(stop_.fd(), spare_.get(), O_CLOEXEC);
}

}  // namespace palpate::transport::zmq
