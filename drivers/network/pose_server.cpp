#include "drivers/network/pose_server.h"

#include <linux/sockios.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "drivers/network/socket.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::network {
namespace {

constexpr int kLookAgainMs = 100;

struct Served {
  FileDescriptor socket;
  std::unique_ptr<ServedClient> client;
  SendQueue queue;
  std::int64_t took_ns = 0;  // when it last had nothing to take, or took of it
  std::uint64_t given = 0;   // bytes handed to the system for it
  std::uint64_t taken = 0;   // of these, those that the system has got rid of
  bool waits = false;        // something is on its way to it
};

std::int64_t clock_ns() { return MonotonicClock<TrackerClock>::monotonic_ns(); }

class Server : public PoseServer {
 public:
  Server(Listening listening, std::unique_ptr<PoseProtocol> protocol, const PoseServerOptions& options,
         Wake wake)
      : listening_(std::move(listening)),
        protocol_(std::move(protocol)),
        options_(options),
        wake_(std::move(wake)),
        thread_([this] { run(); }) {}
  ~Server() override {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.set();
    thread_.join();
  }

  Expected<void> publish(const std::string& tool, Stamp stamp, const RigidPose& pose) override {
    auto bytes = protocol_->encode(tool, stamp, pose);
    if (!bytes) return tl::unexpected(bytes.error());
    {
      const std::lock_guard lock(mutex_);
      ++state_.published;
      inbox_.push_back(
          {tool, stamp, pose, std::make_shared<const std::string>(std::move(*bytes)), clock_ns()});
      if (inbox_.size() > options_.most_waiting) {
        inbox_.pop_front();
        state_.dropped += state_.clients;
      }
      idle_ = false;
    }
    wake_.set();
    return {};
  }

  const Address& address() const override { return listening_.address; }

  PoseServerState state() const override {
    const std::lock_guard lock(mutex_);
    return state_;
  }

  bool drain(Duration at_most) override {
    std::unique_lock lock(mutex_);
    return idle_changed_.wait_for(lock, at_most, [this] { return idle_; });
  }

 private:
  void run() {
    pthread_setname_np(pthread_self(), "palpate-pose-to");
    std::vector<pollfd> items;
    while (true) {
      items.assign({{wake_.fd(), POLLIN, 0},
                    {full_of_files_ ? -1 : listening_.socket.get(), POLLIN, 0},
                    {protocol_->asking_fd(), POLLIN, 0}});
      for (const auto& client : clients_)
        items.push_back(
            {client.socket.get(), static_cast<short>(client.queue.empty() ? POLLIN : POLLIN | POLLOUT), 0});
      const bool waiting =
          std::any_of(clients_.begin(), clients_.end(), [](const auto& c) { return c.waits; });
      ::poll(items.data(), items.size(), full_of_files_ || waiting ? kLookAgainMs : -1);
      full_of_files_ = false;
      if (items[0].revents != 0 && !take_inbox()) return;
      auto item = items.begin() + 3;
      for (auto client = clients_.begin(); client != clients_.end(); ++item) {
        const bool alive =
            (item->revents == 0 || read_from(*client)) && write_to(*client) && !stalled(*client);
        client = alive ? std::next(client) : clients_.erase(client);
      }
      if (items[1].revents != 0) accept_clients();
      if (items[2].revents != 0)
        if (FileDescriptor socket = protocol_->asked()) add(std::move(socket));
      tell_state();
    }
  }

  // False when the server is to end.
  bool take_inbox() {
    wake_.clear();
    std::deque<PublishedPose> inbox;
    {
      const std::lock_guard lock(mutex_);
      if (stop_) return false;
      inbox.swap(inbox_);
    }
    for (auto& client : clients_) {
      const auto push = pusher(client);
      for (const auto& pose : inbox) client.client->pose(pose, push);
      if (!inbox.empty()) client.client->handed_over(push);
    }
    return true;
  }

  ServedClient::Push pusher(Served& client) {
    return [this, &client](SendQueue::Bytes bytes) {
      dropped_ += !client.queue.push(std::move(bytes), options_.most_waiting);
    };
  }

  bool stalled(Served& client) {
    // What the system has taken over still waits there where the client does not read: hundreds of kilobytes,
    // and with few poses minutes of them.
    int in_system = 0;
    if (::ioctl(client.socket.get(), SIOCOUTQ, &in_system) != 0) in_system = 0;
    client.waits = !client.queue.empty() || in_system > 0;
    const std::uint64_t taken =
        client.given - std::min<std::uint64_t>(client.given, static_cast<unsigned>(std::max(in_system, 0)));
    if (!client.waits || taken != client.taken) client.took_ns = clock_ns();
    client.taken = taken;
    if (options_.stalled_after.count() <= 0 || clock_ns() - client.took_ns <= options_.stalled_after.count())
      return false;
    // At once: what it has not taken would keep the connection half open.
    const linger now_or_never{1, 0};
    static_cast<void>(
        ::setsockopt(client.socket.get(), SOL_SOCKET, SO_LINGER, &now_or_never, sizeof now_or_never));
    ++stalled_;
    return true;
  }

  bool read_from(Served& client) {
    char buffer[16 * 1024];
    const ssize_t count = ::recv(client.socket.get(), buffer, sizeof buffer, 0);
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    if (count == 0) return false;
    if (client.client->take({buffer, static_cast<std::size_t>(count)}, pusher(client))) return true;
    ++thrown_out_;
    return false;
  }

  bool write_to(Served& client) {
    while (!client.queue.empty()) {
      const std::string_view next = client.queue.next();
      const ssize_t count =
          ::send(client.socket.get(), next.data(), next.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (count < 0) return errno == EAGAIN || errno == EINTR;
      client.given += static_cast<std::uint64_t>(count);
      if (!client.queue.sent(static_cast<std::size_t>(count))) return true;
      ++sent_;
    }
    return true;
  }

  void accept_clients() {
    while (true) {
      FileDescriptor socket = accept_from(listening_.socket);
      if (!socket) {
        // Without descriptors the waiting client stays where it is, and would wake us at once, again and
        // again.
        full_of_files_ = errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM;
        return;
      }
      add(std::move(socket));
    }
  }

  void add(FileDescriptor socket) {
    if (clients_.size() >= options_.most_clients) {
      ++turned_away_;
      return;
    }
    Served& client = clients_.emplace_back();
    client.socket = std::move(socket);
    client.took_ns = clock_ns();
    client.client = protocol_->meet();
    client.client->begin(pusher(client));
    ++accepted_;
  }

  void tell_state() {
    const bool nothing_left = std::all_of(clients_.begin(), clients_.end(), [](const Served& client) {
      return client.queue.empty() && !client.client->has_more();
    });
    const std::lock_guard lock(mutex_);
    state_.clients = clients_.size();
    state_.accepted = accepted_;
    state_.turned_away = turned_away_;
    state_.thrown_out = thrown_out_;
    state_.stalled = stalled_;
    state_.sent = sent_;
    state_.dropped += std::exchange(dropped_, 0);
    idle_ = nothing_left && inbox_.empty();
    if (idle_) idle_changed_.notify_all();
  }

  Listening listening_;
  const std::unique_ptr<PoseProtocol> protocol_;
  const PoseServerOptions options_;
  Wake wake_;
  // Of the thread alone.
  std::list<Served> clients_;
  bool full_of_files_ = false;
  std::uint64_t accepted_ = 0, turned_away_ = 0, thrown_out_ = 0, stalled_ = 0, sent_ = 0, dropped_ = 0;

  mutable std::mutex mutex_;  // held for moments; guards what follows
  std::condition_variable idle_changed_;
  std::deque<PublishedPose> inbox_;
  PoseServerState state_;
  bool idle_ = true, stop_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace

Expected<std::unique_ptr<PoseServer>> PoseServer::listen(const Address& address, const MakeProtocol& make,
                                                         const PoseServerOptions& options) {
  auto listening = listen_at(address);
  if (!listening) return tl::unexpected(listening.error());
  auto wake = Wake::make();
  if (!wake) return tl::unexpected(wake.error());
  auto protocol = make(listening->address);
  if (!protocol) return tl::unexpected(protocol.error());
  return std::make_unique<Server>(std::move(*listening), std::move(*protocol), options, std::move(*wake));
}

}  // namespace palpate::drivers::network
