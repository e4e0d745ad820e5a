#include "drivers/network/pose_client.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "drivers/network/socket.h"
#include "palpate/core/text.h"
#include "palpate/time/clock.h"
#include "palpate/time/real_time.h"

namespace palpate::drivers::network {
namespace {

// Together well below a second: a server that returns has us back within it.
constexpr int kConnectMs = 400, kRetryMs = 200;
constexpr std::int64_t kLongestWaitMs = 60'000;

std::int64_t now_ns() { return MonotonicClock<TrackerClock>::monotonic_ns(); }

class Client : public PoseClient {
 public:
  Client(std::vector<SocketAddress> addresses, Begin begin, Wake stop)
      : addresses_(std::move(addresses)),
        begin_(std::move(begin)),
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

  PoseClientState state() const override {
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
    pthread_setname_np(pthread_self(), "palpate-pose-in");
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
    const auto conversation = begin_();
    {
      const std::lock_guard lock(mutex_);
      state_.connected = true;
      ++state_.connections;
      before_ = state_.messages;
    }
    Conversation::Turn turn;
    conversation->begin(now_ns(), turn);
    act_on(turn, socket);
    std::string trouble;
    bool go_on = true;
    while (trouble.empty()) {
      const auto due = conversation->due_ns();
      if (due && now_ns() >= *due) {
        const bool fine = conversation->ask(now_ns(), turn);
        if (!fine) trouble = turn.trouble.empty() ? "the server does not answer" : turn.trouble;
        act_on(turn, socket);
        continue;
      }
      const auto wait_ms = due ? std::max<std::int64_t>(*due - now_ns(), 0) / 1'000'000 + 1 : -1;
      bool ready = false;
      go_on =
          wait_for(&socket, POLLIN, static_cast<int>(std::min<std::int64_t>(wait_ms, kLongestWaitMs)), ready);
      if (!go_on) break;
      if (ready) trouble = receive(socket, *conversation);
    }
    if (!go_on) {
      conversation->end(turn);
      act_on(turn, socket);
    }
    const std::lock_guard lock(mutex_);
    state_.connected = false;
    if (!trouble.empty()) state_.trouble = trouble;
    return go_on;
  }

  // Empty, or why the connection is over.
  std::string receive(const FileDescriptor& socket, Conversation& conversation) {
    const ssize_t count = ::recv(socket.get(), buffer_, sizeof buffer_, 0);
    if (count == 0) return "the server has closed the connection";
    if (count < 0)
      return errno == EAGAIN || errno == EINTR
                 ? ""
                 : fmt::format("the connection broke: {}", std::strerror(errno));
    Conversation::Turn turn;
    const bool fine = conversation.take({buffer_, static_cast<std::size_t>(count)}, now_ns(), turn);
    const std::string trouble = turn.trouble;
    act_on(turn, socket);
    const auto counts = conversation.counts();
    const std::lock_guard lock(mutex_);
    state_.messages = {before_.damaged + counts.damaged, before_.refused + counts.refused,
                       before_.skipped + counts.skipped};
    return fine ? "" : trouble.empty() ? "the server speaks another protocol" : trouble;
  }

  // Keeps what was heard and sends what is to go: a few bytes on a connection that is otherwise not written to leave at once,
  // or not at all.
  void act_on(Conversation::Turn& turn, const FileDescriptor& socket) {
    for (const auto& sample : turn.heard) keep(sample);
    if (!turn.out.empty())
      static_cast<void>(::send(socket.get(), turn.out.data(), turn.out.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
    if (!turn.trouble.empty()) {
      const std::lock_guard lock(mutex_);
      state_.trouble = turn.trouble;
    }
    turn = {};
  }

  void keep(const ToolSample& sample) {
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

  const std::vector<SocketAddress> addresses_;
  const Begin begin_;
  Wake stop_;
  // Of the thread alone.
  char buffer_[64 * 1024];
  Conversation::Counts before_;  // of the connections before this one
  std::map<std::string, ToolSample> last_;

  mutable std::mutex mutex_;  // held for moments; guards what follows
  PoseClientState state_;
  std::deque<ToolSample> waiting_;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace

Expected<std::unique_ptr<PoseClient>> PoseClient::connect(const Address& server, Begin begin) {
  auto addresses = resolve(server);
  if (!addresses) return tl::unexpected(addresses.error());
  auto stop = Wake::make();
  if (!stop) return tl::unexpected(stop.error());
  return std::make_unique<Client>(std::move(*addresses), std::move(begin), std::move(*stop));
}

}  // namespace palpate::drivers::network
