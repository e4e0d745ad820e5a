#include "drivers/openigtlink/tracker_client.h"

#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "drivers/openigtlink/internal/socket.h"
#include "drivers/openigtlink/message_stream.h"
#include "palpate/core/text.h"
#include "palpate/time/clock.h"
#include "palpate/time/real_time.h"

namespace palpate::drivers::openigtlink {
namespace {

// Together well below a second: a server that returns has us back within it.
constexpr int kConnectMs = 400, kRetryMs = 200;
constexpr std::int64_t kSilenceNs = 500'000'000;
constexpr std::uint16_t kAllIsWell = 1;  // of STATUS

std::int64_t now_ns() { return MonotonicClock<TrackerClock>::monotonic_ns(); }

class Client : public TrackerClient {
 public:
  Client(std::vector<SocketAddress> addresses, const TrackerClientOptions& options, Wake stop)
      : addresses_(std::move(addresses)),
        options_(options),
        stop_(std::move(stop)),
        thread_([this] { run(); }) {}
  ~Client() override {
    stop_.set();
    thread_.join();
  }

  std::vector<ToolSample> poll() override {
    const std::lock_guard lock(mutex_);
    std::vector<ToolSample> taken(std::make_move_iterator(waiting_.begin()),
                                  std::make_move_iterator(waiting_.end()));
    waiting_.clear();
    return taken;
  }

  TrackerClientState state() const override {
    const std::lock_guard lock(mutex_);
    return state_;
  }

 private:
  // Waits until the socket is ready, at most so long; false when the client is to end.
  bool wait_for(const FileDescriptor* socket, short events, int ms, bool& ready) {
    pollfd items[] = {{stop_.fd(), POLLIN, 0}, {socket != nullptr ? socket->get() : -1, events, 0}};
    const int count = ::poll(items, 2, ms);
    ready = count > 0 && items[1].revents != 0;
    return count <= 0 || items[0].revents == 0;
  }

  void run() {
    pthread_setname_np(pthread_self(), "palpate-igtl-in");
    ask_for_short_turns();  // it notes when samples arrive
    bool ready = false;
    while (true) {
      for (const auto& address : addresses_) {
        const FileDescriptor socket = begin_connect(address);
        if (!socket) continue;
        if (!wait_for(&socket, POLLOUT, kConnectMs, ready)) return;
        if (!ready || !connected(socket)) continue;
        if (!converse(socket)) return;
        break;
      }
      if (!wait_for(nullptr, 0, kRetryMs, ready)) return;
    }
  }

  // As long as the connection stands; false when the client is to end.
  bool converse(const FileDescriptor& socket) {
    MessageStream stream;
    {
      const std::lock_guard lock(mutex_);
      state_.connected = true;
      ++state_.connections;
      before_ = state_;
    }
    heard_pose_ = false;
    bool asked = options_.start == StartRequest::never;
    const std::int64_t ask_at = now_ns() + (options_.start == StartRequest::at_once ? 0 : kSilenceNs);
    std::string trouble;
    bool go_on = true;
    while (trouble.empty()) {
      if (!asked && !heard_pose_ && now_ns() >= ask_at) {
        send(socket, StartTracking{options_.period_ms, ""});
        asked = true;
      }
      const bool may_ask = !asked && !heard_pose_;
      const auto wait_ns = std::max<std::int64_t>(ask_at - now_ns(), 0);
      bool ready = false;
      go_on = wait_for(&socket, POLLIN, may_ask ? static_cast<int>(wait_ns / 1'000'000 + 1) : -1, ready);
      if (!go_on) break;
      if (ready) trouble = receive(socket, stream);
    }
    if (!go_on && asked && options_.start != StartRequest::never) send(socket, StopTracking{});
    const std::lock_guard lock(mutex_);
    state_.connected = false;
    if (!trouble.empty()) state_.trouble = trouble;
    return go_on;
  }

  // Empty, or why the connection is over.
  std::string receive(const FileDescriptor& socket, MessageStream& stream) {
    const ssize_t count = ::recv(socket.get(), buffer_, sizeof buffer_, 0);
    if (count == 0) return "the server has closed the connection";
    if (count < 0)
      return errno == EAGAIN || errno == EINTR
                 ? ""
                 : fmt::format("the connection broke: {}", std::strerror(errno));
    const std::int64_t arrived = now_ns();
    const bool fine = stream.take({buffer_, static_cast<std::size_t>(count)},
                                  [&](Message&& message) { hear(std::move(message), arrived); });
    const auto& counts = stream.counts();
    const std::lock_guard lock(mutex_);
    state_.bad_crc = before_.bad_crc + counts.bad_crc;
    state_.refused = before_.refused + counts.refused;
    state_.skipped = before_.skipped + counts.skipped;
    if (!stream.complaint().empty()) state_.trouble = stream.complaint();
    return fine ? "" : stream.complaint();
  }

  void hear(Message&& message, std::int64_t arrived) {
    ToolSample sample;
    sample.arrived_ns = arrived;
    sample.server_time = message.stamp.has_value();
    sample.stamp = message.stamp.value_or(Instant<TrackerClock>{Duration(arrived)});
    if (const auto* transform = std::get_if<Transform>(&message.content)) {
      sample.tool = std::move(message.device);
      sample.seen = transform->valid;
      sample.pose = transform->pose;
      keep(sample);
    } else if (auto* data = std::get_if<TrackingData>(&message.content)) {
      for (auto& tool : data->tools) {
        sample.tool = std::move(tool.name);
        sample.pose = tool.pose;
        keep(sample);
      }
    } else if (const auto* status = std::get_if<Status>(&message.content);
               status && status->code != kAllIsWell) {
      const std::lock_guard lock(mutex_);
      state_.trouble = fmt::format("the server says: status {} {} {}", status->code, status->name,
                                   excerpt(status->text, 120));
    }
  }

  void keep(const ToolSample& sample) {
    heard_pose_ = true;
    const std::lock_guard lock(mutex_);
    const auto last = last_.find(sample.tool);
    if (last == last_.end() && last_.size() >= kMostTools) {
      ++state_.too_many;
      return;
    }
    if (last != last_.end() && same(last->second, sample)) {
      ++state_.repeats;
      return;
    }
    last_[sample.tool] = sample;
    if (waiting_.size() >= kMostWaiting) {
      waiting_.pop_front();
      ++state_.lost;
    }
    waiting_.push_back(sample);
    ++state_.samples;
  }

  // A server may send the newest pose at a fixed rate whether it is new or not.
  static bool same(const ToolSample& a, const ToolSample& b) {
    return a.server_time && b.server_time && a.stamp == b.stamp && a.seen == b.seen &&
           a.pose.translation == b.pose.translation && a.pose.rotation.coeffs() == b.pose.rotation.coeffs();
  }

  // A few bytes on a connection that is otherwise not written to: they leave at once, or not at all.
  static void send(const FileDescriptor& socket, Content content) {
    const auto bytes = encode({"", {}, std::move(content)});
    if (bytes)
      static_cast<void>(::send(socket.get(), bytes->data(), bytes->size(), MSG_NOSIGNAL | MSG_DONTWAIT));
  }

  const std::vector<SocketAddress> addresses_;
  const TrackerClientOptions options_;
  Wake stop_;
  // Of the thread alone.
  char buffer_[64 * 1024];
  bool heard_pose_ = false;
  TrackerClientState before_;  // counts of the connections before this one
  std::map<std::string, ToolSample> last_;

  mutable std::mutex mutex_;  // held for moments; guards what follows
  TrackerClientState state_;
  std::deque<ToolSample> waiting_;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace

Expected<std::unique_ptr<TrackerClient>> TrackerClient::connect(const Address& server,
                                                                const TrackerClientOptions& options) {
  auto addresses = resolve(server);
  if (!addresses) return tl::unexpected(addresses.error());
  auto stop = Wake::make();
  if (!stop) return tl::unexpected(stop.error());
  return std::make_unique<Client>(std::move(*addresses), options, std::move(*stop));
}

}  // namespace palpate::drivers::openigtlink
