#include "palpate/transport/internal/zmq_authenticator.h"

#include <sys/stat.h>
#include <zmq.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <vector>

namespace palpate::transport::zmq {
namespace {

constexpr Duration kLookEvery = std::chrono::milliseconds(500);
constexpr std::size_t kKeyBytes = 32;
// A question of ZeroMQ's: version, number, domain, address, identity, mechanism, the client's key.
constexpr std::size_t kQuestionFrames = 7, kNumberFrame = 1, kMechanismFrame = 5, kKeyFrame = 6;

bool set_text(Socket& socket, int option, const std::string& text) {
  return zmq_setsockopt(socket.get(), option, text.c_str(), text.size()) == 0;
}

// All frames of the next question.
std::vector<std::string> next_question(void* socket) {
  std::vector<std::string> frames;
  for (bool more = true; more;) {
    zmq_msg_t frame;
    zmq_msg_init(&frame);
    const bool there = zmq_msg_recv(&frame, socket, ZMQ_DONTWAIT) >= 0;
    if (there) frames.emplace_back(static_cast<const char*>(zmq_msg_data(&frame)), zmq_msg_size(&frame));
    more = there && zmq_msg_more(&frame) != 0;
    zmq_msg_close(&frame);
  }
  return frames;
}

std::string key_of(const std::string& bytes) {
  std::array<char, 41> text{};
  if (bytes.size() != kKeyBytes ||
      zmq_z85_encode(text.data(), reinterpret_cast<const std::uint8_t*>(bytes.data()), kKeyBytes) == nullptr)
    return {};
  return text.data();
}

}  // namespace

Expected<Authenticator> Authenticator::make(const Context& context, ServerIdentity identity) {
  auto socket = Socket::make(ZMQ_REP, context);
  if (!socket) return tl::unexpected(socket.error());
  if (zmq_bind(socket->get(), "inproc://zeromq.zap.01") != 0)
    return refused("ZeroMQ takes no gate keeper: {}", reason_of(errno));
  auto admitted = read_authorized_keys(identity.folder);
  if (!admitted) return tl::unexpected(admitted.error());
  Authenticator authenticator(std::move(*socket), std::move(identity), std::move(*admitted));
  authenticator.stamp_ = authenticator.stamp();
  return authenticator;
}

Expected<void> Authenticator::guard(Socket& socket) const {
  const int server = 1;
  if (zmq_setsockopt(socket.get(), ZMQ_CURVE_SERVER, &server, sizeof server) == 0 &&
      set_text(socket, ZMQ_CURVE_SECRETKEY, identity_.own.secret_key) &&
      set_text(socket, ZMQ_ZAP_DOMAIN, "palpate"))
    return {};
  return refused("ZeroMQ cannot encrypt: {}", reason_of(errno));
}

void Authenticator::answer(const std::function<bool(const std::string& key)>& full) {
  // Bounded: strangers who try without end must not keep the thread from those who are in.
  for (int i = 0; i < kQueueLength; ++i) {
    const auto question = next_question(socket_.get());
    if (question.empty()) return;
    const bool whole = question.size() == kQuestionFrames && question[kMechanismFrame] == "CURVE";
    const std::string key = whole ? key_of(question[kKeyFrame]) : std::string();
    const bool admitted = !key.empty() && role_of(key).has_value();
    const std::uint32_t answer = !admitted ? kNotAdmitted : full(key) ? kNoPlace : kWelcome;
    if (answer != kWelcome) ++rejected_connections_;
    const std::string number = question.size() > kNumberFrame ? question[kNumberFrame] : std::string();
    socket_.send("1.0", true);
    socket_.send(number, true);
    socket_.send(std::to_string(answer), true);
    socket_.send(answer == kWelcome ? ""
                 : admitted         ? "too many connections"
                                    : "this key is not admitted",
                 true);
    socket_.send(key, true);
    socket_.send("");
  }
}

std::optional<Role> Authenticator::role_of(const std::string& user) const {
  const std::lock_guard lock(admitted_->mutex);
  return admitted_->list.role_of(user);
}

// What tells one version of the file from another, and whose it and its folder are.
std::string Authenticator::stamp() const {
  struct stat folder {
  }, info{};
  if (stat(identity_.folder.c_str(), &folder) != 0) return "none";
  if (stat((identity_.folder / "authorized_keys").c_str(), &info) != 0) return "none";
  return fmt::format("{} {:o} {} {} {} {} {:o} {}.{:09}", folder.st_uid, folder.st_mode, info.st_dev,
                     info.st_ino, info.st_size, info.st_uid, info.st_mode, info.st_mtim.tv_sec,
                     info.st_mtim.tv_nsec);
}

bool Authenticator::look_again(Duration now) {
  if (looked_ && now - *looked_ < kLookEvery) return false;
  looked_ = now;
  std::string there = stamp();
  if (there == stamp_) return false;
  auto read = read_authorized_keys(identity_.folder);
  if (!read && read.error().code == ErrorCode::exhausted) return false;
  stamp_ = std::move(there);
  // A file that cannot be trusted any more admits nobody.
  auto before = std::move(read).value_or(AuthorizedKeys{});
  {
    const std::lock_guard lock(admitted_->mutex);
    std::swap(before, admitted_->list);
  }
  return std::any_of(before.keys.begin(), before.keys.end(),
                     [&](const AuthorizedKey& one) { return !role_of(one.key); });
}

Expected<void> encrypt(Socket& socket, const ClientIdentity& identity) {
  if (set_text(socket, ZMQ_CURVE_PUBLICKEY, identity.own.public_key) &&
      set_text(socket, ZMQ_CURVE_SECRETKEY, identity.own.secret_key) &&
      set_text(socket, ZMQ_CURVE_SERVERKEY, identity.server_key))
    return {};
  return refused("ZeroMQ cannot encrypt: {}", reason_of(errno));
}

}  // namespace palpate::transport::zmq
