#include "palpate/transport/zmq_socket.h"

#include <sys/eventfd.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <future>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "palpate/core/random.h"
#include "palpate/core/system_error.h"
#include "palpate/time/clock.h"
#include "palpate/time/real_time.h"
#include "palpate/transport/messages.h"

namespace palpate::transport::zmq {

namespace {

constexpr int kDescriptorsOfContext = 16;  // with its first sockets
constexpr std::chrono::seconds kEndsWithin{2};

// libzmq ends the process where it finds none.
Expected<void> check_descriptors() {
  std::array<FileDescriptor, kDescriptorsOfContext> taken;
  std::size_t count = 0;
  while (count < taken.size() && (taken[count] = FileDescriptor(::eventfd(0, EFD_CLOEXEC)))) ++count;
  if (count == taken.size()) return {};
  return refused(
      ErrorCode::exhausted,
      "too few descriptors for a connection: {} are left, {} are needed; raise the limit (ulimit -n)", count,
      kDescriptorsOfContext);
}

// Waits until libzmq has let go of everything, but not for as long as somebody likes who has filled its
// memory: what is left then goes with the process.
void end_context(void* context) {
  auto ended = std::make_shared<std::promise<void>>();
  auto end = ended->get_future();
  try {
    std::thread([context, ended] {
      zmq_ctx_term(context);
      ended->set_value();
    }).detach();
  } catch (const std::system_error&) {  // no thread to be had
    zmq_ctx_term(context);
    return;
  }
  end.wait_for(kEndsWithin);
}

// By itself, as ZeroMQ makes the text in a thread of its own and the thread sanitizer cannot see how it is handed over
// (cmake/tsan.supp).
void copy_user(zmq_msg_t* message, std::string& user) {
  const char* key = zmq_msg_gets(message, "User-Id");
  if (key != nullptr) user.assign(key);
}

}  // namespace

std::string reason_of(int error) {
  return error > ZMQ_HAUSNUMERO ? std::string(zmq_strerror(error)) : core::reason_of(error);
}

Expected<Context> make_context() {
  if (auto enough = check_descriptors(); !enough) return tl::unexpected(enough.error());
  void* context = zmq_ctx_new();
  if (context == nullptr) return refused("ZeroMQ cannot start: {}", reason_of(errno));
  zmq_ctx_set(context, ZMQ_BLOCKY, 0);
  // ZeroMQ starts its threads with the first socket; they inherit the turns of the thread that made it.
  try {
    std::thread([context] {
      ask_for_short_turns();
      if (void* first = zmq_socket(context, ZMQ_PAIR)) zmq_close(first);
    }).join();
  } catch (const std::system_error&) {  // no thread to be had: ZeroMQ will say so
  }
  return Context(context, end_context);
}

Expected<Socket> Socket::make(int type, Context context, std::optional<std::size_t> max_frame_bytes) {
  if (!context) {
    auto own = make_context();
    if (!own) return tl::unexpected(own.error());
    context = std::move(*own);
  }
  void* socket = zmq_socket(context.get(), type);
  if (socket == nullptr) return refused("ZeroMQ gives no socket: {}", reason_of(errno));
  Socket result(std::move(context), socket);
  const auto set = [&](int option, int value) {
    return zmq_setsockopt(socket, option, &value, sizeof value) == 0;
  };
  // Shapes go to graphics servers alone, and are the only large thing.
  const std::int64_t limit = static_cast<std::int64_t>(
      max_frame_bytes.value_or(type == ZMQ_DEALER ? kMaxShapeBytes : kMaxMessageBytes));
  // IMMEDIATE: a question does not wait for a server to appear. It also keeps libzmq 4.3.4 from an assertion
  // that ends the process: a socket whose full queue has cost it its connection's heartbeat must not keep
  // that queue.
  const bool good = set(ZMQ_LINGER, 0) && set(ZMQ_SNDHWM, kQueueLength) && set(ZMQ_RCVHWM, kQueueLength) &&
                    set(ZMQ_IMMEDIATE, 1) && set(ZMQ_BACKLOG, kBacklog) &&
                    set(ZMQ_RECONNECT_IVL, kReconnectMs) && set(ZMQ_HEARTBEAT_IVL, kHeartbeatMs) &&
                    set(ZMQ_HEARTBEAT_TIMEOUT, kHeartbeatTimeoutMs) && set(ZMQ_HANDSHAKE_IVL, kHandshakeMs) &&
                    set(ZMQ_CONNECT_TIMEOUT, kConnectMs) &&
                    zmq_setsockopt(socket, ZMQ_MAXMSGSIZE, &limit, sizeof limit) == 0 &&
                    // Says so when a peer has gone or its queue is full, instead of dropping in silence.
                    (type != ZMQ_ROUTER || (set(ZMQ_ROUTER_MANDATORY, 1) && result.receive_without_bound()));
  if (!good) return refused("ZeroMQ refuses a socket option: {}", reason_of(errno));
  return result;
}

// Where libzmq 4.3.4 has stopped reading from a connection because its queue is full, and the connection
// ends, the next sign of life is an assertion that ends the process. So no peer must be able to fill the
// queue of a server: its reader passes over what is too much (rate_limit.h), and its connections end before it closes
// (ConnectionGuard::leave).
bool Socket::receive_without_bound() {
  const int none = 0;
  return zmq_setsockopt(socket_, ZMQ_RCVHWM, &none, sizeof none) == 0;
}

Socket::Socket(Socket&& other) noexcept
    : context_(std::move(other.context_)), socket_(std::exchange(other.socket_, nullptr)) {}

Socket::~Socket() {
  if (socket_ != nullptr) zmq_close(socket_);
}

Expected<void> Socket::bind(const std::string& address) {
  const mode_t before = umask(0177);
  const int bound = zmq_bind(socket_, address.c_str());
  const int error = errno;
  umask(before);
  if (bound == 0) return {};
  if (error == EADDRINUSE)
    return refused(ErrorCode::in_use,
                   "{}: address in use; stop the other server or listen at another address", address);
  if (error == EMFILE || error == ENFILE)
    return refused(ErrorCode::exhausted,
                   "{}: no descriptor left to listen there; raise the limit (ulimit -n)", address);
  return refused("{}: cannot listen there: {}", address, reason_of(error));
}

int Socket::fd() const {
  int fd = -1;
  std::size_t size = sizeof fd;
  zmq_getsockopt(socket_, ZMQ_FD, &fd, &size);
  return fd;
}

bool Socket::readable() const {
  int events = 0;
  std::size_t size = sizeof events;
  return zmq_getsockopt(socket_, ZMQ_EVENTS, &events, &size) == 0 && (events & ZMQ_POLLIN) != 0;
}

std::string Socket::endpoint() const {
  char text[512] = {};
  std::size_t size = sizeof text;
  return zmq_getsockopt(socket_, ZMQ_LAST_ENDPOINT, text, &size) == 0 ? std::string(text) : std::string();
}

Socket::Received Socket::receive(int frames, std::string* peer, std::string& body, Sender* sender,
                                 std::vector<Frame>* rest) {
  if (sender != nullptr) *sender = {};
  if (rest != nullptr) rest->clear();
  int count = 0;
  for (bool more = true; more; ++count) {
    Frame frame;
    if (zmq_msg_recv(frame.get(), socket_, ZMQ_DONTWAIT) < 0)
      return count == 0 ? Received::nothing : Received::rejected;
    std::string* target = count == frames - 1 ? &body : peer;
    if (count < frames && target != nullptr) target->assign(frame.bytes());
    if (sender != nullptr && count == frames - 1) {
      copy_user(frame.get(), sender->user);
      sender->descriptor = zmq_msg_get(frame.get(), ZMQ_SRCFD);
    }
    more = zmq_msg_more(frame.get()) != 0;
    if (rest != nullptr && count >= frames && rest->size() < kMaxShapePieces)
      rest->push_back(std::move(frame));
  }
  const int most = frames + (rest == nullptr ? 0 : static_cast<int>(kMaxShapePieces));
  return count >= frames && count <= most ? Received::message : Received::rejected;
}

bool Socket::send(std::string_view bytes, bool more) {
  return zmq_send(socket_, bytes.data(), bytes.size(), ZMQ_DONTWAIT | (more ? ZMQ_SNDMORE : 0)) >= 0;
}

bool Socket::send(std::string_view bytes, std::shared_ptr<const void> owner, bool more) {
  // ZeroMQ passes it to a thread of its own; `handed_over` does so once more, where a thread sanitizer sees
  // it.
  struct Kept {
    explicit Kept(std::shared_ptr<const void> what) : owner(std::move(what)) {}
    std::shared_ptr<const void> owner;
    std::atomic<bool> handed_over{false};
  };
  auto hint = std::make_unique<Kept>(std::move(owner));
  hint->handed_over.store(true, std::memory_order_release);
  zmq_msg_t frame;
  const auto let_go = [](void*, void* pointer) {
    auto* kept = static_cast<Kept*>(pointer);
    if (kept->handed_over.load(std::memory_order_acquire)) delete kept;
  };
  // ZeroMQ only reads what it sends.
  if (zmq_msg_init_data(&frame, const_cast<char*>(bytes.data()), bytes.size(), let_go, hint.get()) != 0)
    return false;
  static_cast<void>(hint.release());
  if (zmq_msg_send(&frame, socket_, ZMQ_DONTWAIT | (more ? ZMQ_SNDMORE : 0)) >= 0) return true;
  zmq_msg_close(&frame);
  return false;
}

std::uint64_t new_name(std::string_view purpose) {
  static std::atomic<std::uint64_t> count{0};
  const auto time = static_cast<std::uint64_t>(MonotonicClock<PhysicsClock>::monotonic_ns());
  const auto process = static_cast<std::uint64_t>(::getpid());
  Random random(time ^ (process << 40) ^ (count.fetch_add(1) << 32), purpose);
  std::uint64_t name = random.bits();
  while (name == 0) name = random.bits();
  return name;
}

Stop::Stop() : fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!fd_) throw std::runtime_error("no descriptor left; raise the limit (ulimit -n)");
}
void Stop::set() {
  const std::uint64_t one = 1;
  // Fails only when the counter is full, and then it is set.
  static_cast<void>(!::write(fd(), &one, sizeof one));
}

void Stop::clear() {
  std::uint64_t count = 0;
  static_cast<void>(!::read(fd(), &count, sizeof count));  // empty already: as wanted
}

}  // namespace palpate::transport::zmq
