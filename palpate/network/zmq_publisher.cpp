#include "palpate/network/zmq_publisher.h"

#include <poll.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <charconv>

#include "palpate/network/messages.h"
#include "palpate/time/real_time.h"

namespace palpate::zmq {
namespace {

constexpr std::string_view kTopic = "state@";
constexpr Duration kLookAtLeastEvery = std::chrono::milliseconds(100);

// The rate that a topic names; 0 where it names none.
int rate_of(std::string_view topic) {
  if (!topic.starts_with(kTopic) || !topic.ends_with(';')) return 0;
  topic.remove_prefix(kTopic.size());
  topic.remove_suffix(1);
  int rate = 0;
  const auto read = std::from_chars(topic.data(), topic.data() + topic.size(), rate);
  const bool whole = read.ec == std::errc() && read.ptr == topic.data() + topic.size();
  return whole && rate >= 1 && rate <= kMaxRate && topic_of(rate) == fmt::format("{}{};", kTopic, topic)
             ? rate
             : 0;
}

Expected<Socket> open_socket(const Context& context, const std::string& address, const Gate* gate) {
  auto socket = Socket::make(ZMQ_XPUB, context);
  if (!socket) return socket;
  if (gate != nullptr)
    if (auto guarded = gate->guard(*socket, kStatesDomain); !guarded) return tl::unexpected(guarded.error());
  if (auto bound = socket->bind(address); !bound) return tl::unexpected(bound.error());
  return socket;
}

}  // namespace

std::string topic_of(int rate_hz) { return fmt::format("{}{};", kTopic, rate_hz); }

Expected<std::unique_ptr<Publisher>> Publisher::make(const Context& context, const Endpoint& endpoint,
                                                     const Gate* gate, const Clock<PhysicsClock>& clock,
                                                     StateSource source) {
  std::optional<SocketClaim> claim;
  if (endpoint.local()) {
    auto taken = SocketClaim::take(endpoint.socket);
    if (!taken) return tl::unexpected(taken.error());
    claim = std::move(*taken);
  }
  auto socket = open_socket(context, endpoint.address, gate);
  if (!socket) return tl::unexpected(socket.error());
  return std::make_unique<Publisher>(context, std::move(*socket), gate, std::move(claim), clock,
                                     std::move(source));
}

Publisher::Publisher(Context context, Socket socket, const Gate* gate, std::optional<SocketClaim> claim,
                     const Clock<PhysicsClock>& clock, StateSource source)
    : claim_(std::move(claim)),
      context_(std::move(context)),
      gate_(gate),
      socket_(std::move(socket)),
      endpoint_(socket_->endpoint()),
      clock_(clock),
      source_(std::move(source)),
      thread_([this] { run(); }) {}

Publisher::~Publisher() {
  stop_.set();
  thread_.join();
}

void Publisher::begin_anew() {
  anew_ = true;
  wake_.set();
}

void Publisher::run() {
  name_and_pin_thread("palpate-pub", -1);
  while (true) {
    if (anew_.exchange(false)) reopen();
    const Instant<PhysicsClock> now = clock_.now();
    publish_what_is_due(now);
    // After the sending, which may have swallowed the signal that a wish has come.
    take_wishes();
    Duration wait = kLookAtLeastEvery;
    for (const auto& [hz, rate] : rates_) wait = std::min(wait, rate.due - clock_.now());
    wait = std::max(wait, Duration(0));
    const timespec time{wait.count() / 1'000'000'000, wait.count() % 1'000'000'000};
    pollfd items[] = {
        {socket_ ? socket_->fd() : -1, POLLIN, 0}, {stop_.fd(), POLLIN, 0}, {wake_.fd(), POLLIN, 0}};
    ::ppoll(items, 3, &time, nullptr);
    if ((items[1].revents & POLLIN) != 0) return;
    if ((items[2].revents & POLLIN) != 0) wake_.clear();
  }
}

// A wish is one frame: 1 (from now on) or 0 (no longer) and the topic. ZeroMQ tells the first observer's of a
// topic and the last one's end.
void Publisher::take_wishes() {
  std::string wish, user;
  bool changed = false;
  while (socket_ && socket_->readable() &&
         socket_->receive(1, nullptr, wish, &user) != Socket::Received::nothing) {
    if (wish.empty()) continue;
    const std::string topic = wish.substr(1);
    if (wish[0] == 0 && topics_.erase(topic) > 0) topic_bytes_ -= topic.size(), changed = true;
    if (wish[0] == 1 && topics_.emplace(topic, user).second) topic_bytes_ += topic.size(), changed = true;
    if (topic_bytes_ > kMaxTopicBytes) return shut_out_the_greediest();
  }
  if (changed) choose_rates();
}

// Those served already go on; a place that has come free is the next one's that waits.
void Publisher::choose_rates() {
  std::map<int, const std::string*> wanted;
  for (const auto& [topic, user] : topics_)
    if (const int hz = rate_of(topic); hz != 0) wanted.emplace(hz, &user);
  std::map<std::string, std::size_t> each;
  for (auto rate = rates_.begin(); rate != rates_.end();) {
    const auto still = wanted.find(rate->first);
    if (still != wanted.end()) ++each[*still->second];
    rate = still == wanted.end() ? rates_.erase(rate) : std::next(rate);
  }
  for (const auto& [hz, user] : wanted) {
    if (rates_.size() >= kMaxRatesAtOnce) return;
    if (rates_.contains(hz) || (!user->empty() && each[*user] >= kMaxRatesEach)) continue;
    ++each[*user];
    rates_.emplace(hz, Rate{clock_.now()});
  }
}

// What ZeroMQ holds for a connection goes with the socket alone. The others come back within a moment.
void Publisher::shut_out_the_greediest() {
  std::map<std::string, std::size_t> bytes;
  for (const auto& [topic, user] : topics_) bytes[user] += topic.size();
  const auto most = std::max_element(bytes.begin(), bytes.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  if (gate_ != nullptr && most != bytes.end() && !most->first.empty()) gate_->keep_from_states(most->first);
  floods_.fetch_add(1, std::memory_order_relaxed);
  reopen();
}

void Publisher::publish_what_is_due(Instant<PhysicsClock> now) {
  for (auto& [hz, rate] : rates_) {
    if (now < rate.due) continue;
    const Duration period = seconds(1.0 / hz);
    // What was slept over is not made up for.
    rate.due = std::max(rate.due + period, now - period + Duration(1));
    const Instant<PhysicsClock> time = now - kObserverDelay;
    const StateAnswer answer = source_(time);
    if (!answer.usable()) continue;
    if (socket_ && socket_->send(topic_of(hz), true) &&
        socket_->send(encode(ServerMessage(StateReply{++rate.number, time, answer, nullptr}))))
      published_.fetch_add(1, std::memory_order_relaxed);
  }
}

void Publisher::reopen() {
  rates_.clear();
  topics_.clear();
  topic_bytes_ = 0;
  socket_.reset();
  // The address comes free a moment after the socket has closed; until then nobody gets anything.
  for (int attempt = 0; attempt < 100 && !socket_; ++attempt) {
    auto socket = open_socket(context_, endpoint_, gate_);
    if (socket)
      socket_.emplace(std::move(*socket));
    else
      ::usleep(10'000);
  }
  if (!socket_) begin_anew();  // tried again, as long as it takes
}

}  // namespace palpate::zmq
