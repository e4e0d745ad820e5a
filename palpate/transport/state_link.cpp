#include "palpate/transport/state_link.h"

#include <algorithm>
#include <utility>

#include "palpate/core/text.h"

namespace palpate::transport {

namespace {
constexpr std::size_t kMaxWishes = 16;
constexpr int kMostTaken = 1024;
constexpr std::size_t kMaxSyncsKept = 64;
}  // namespace

StateLink::StateLink(std::unique_ptr<LinkWire> wire, std::uint64_t client, std::string name)
    : wire_(std::move(wire)), client_(client), name_(std::move(name)) {
  if (name_.size() > kMaxNameBytes) name_ = excerpt(name_, kMaxNameBytes - 3);
  arrived_.reserve(64);
}

std::optional<std::string> StateLink::trouble() const {
  const auto kind = wire_->trouble();
  if (!kind) return std::nullopt;
  if (*kind == LinkTrouble::not_admitted)
    return "it does not admit the key of this machine (palpate keys show); there, `palpate keys authorize` "
           "does";
  if (*kind == LinkTrouble::no_place)
    return "it takes no more connections with the key of this machine; end other programs here that talk to "
           "it";
  if (*kind == LinkTrouble::flood)
    return "it sends far more than anybody asked it for, and was cut off; is a physics server of this "
           "release "
           "there?";
  return "its encryption does not agree with ours: it has another key than the one entered here (palpate "
         "keys trust), or one side is --insecure";
}

std::optional<Instant<GraphicsClock>> StateLink::send(const ClientMessage& message) {
  const auto sent = wire_->send(message);
  if (!unanswered_since_) unanswered_since_ = sent ? *sent : wire_->now();
  return sent;
}

bool StateLink::request(std::uint64_t number, Instant<PhysicsClock> time, bool shape) {
  if (!request_tracker_.may_send(number)) return false;
  const auto sent = send(StateRequest{number, time, shape});
  if (!sent) {
    request_tracker_.unsent();
    return false;
  }
  request_tracker_.sent(number, *sent);
  return true;
}

bool StateLink::look_back(std::uint64_t number, Instant<PhysicsClock> time, bool shape) {
  return send(StateRequest{number | kLookBack, time, shape}).has_value();
}

void StateLink::poll() {
  arrived_.clear();
  looked_back_.clear();
  Arrival arrival;
  // Bounded, should more come all the while.
  for (int taken = 0; taken < kMostTaken && wire_->take(arrival); ++taken) {
    if (!arrival.message) {
      request_tracker_.rejected();
      continue;
    }
    last_word_ = arrival.received;
    unanswered_since_.reset();
    std::visit([&](const auto& message) { take(message, arrival); }, *arrival.message);
  }
  const Instant<GraphicsClock> now = wire_->now();
  request_tracker_.expire(now);
  say_hello(now);
  send_pending(now);
}

void StateLink::say_hello(Instant<GraphicsClock> now) {
  if (last_hello_ && now - *last_hello_ < kHelloEvery) return;
  // Without a connection the next poll tries again, so that the first word follows the connection at once.
  if (send(Hello{client_, description_ ? session_ : 0, name_, figures_})) last_hello_ = now;
}

void StateLink::send_pending(Instant<GraphicsClock> now) {
  while (!pending_.empty() && now - pending_.front().made > kControlKept) {
    pending_.pop_front();
    ++controls_dropped_;
  }
  if (pending_.empty() || session_ == 0) return;
  PendingControl& pending = pending_.front();
  if (pending.sent && now - *pending.sent < kHelloEvery) return;
  if (send(pending.call)) pending.sent = now;
}

bool StateLink::send_control(scene::Control control) {
  if (pending_.size() >= kMaxWishes) return false;
  const Instant<GraphicsClock> now = wire_->now();
  pending_.push_back({.call = {client_, ++controls_made_, control}, .made = now});
  send_pending(now);
  return true;
}

bool StateLink::send_sync() {
  const std::uint64_t number = trains_ * LinkWire::kSyncTrain + 1;
  const auto sent = send(SyncRequest{number});
  if (!sent) return false;
  syncs_sent_[trains_++ % syncs_sent_.size()] = {number, *sent};
  return true;
}

std::optional<SyncStamps> StateLink::take_sync() {
  if (syncs_done_.empty()) return std::nullopt;
  const SyncStamps stamps = syncs_done_.front();
  syncs_done_.pop_front();
  return stamps;
}

void StateLink::take(const Welcome& message, const Arrival&) {
  session_ = message.session;
  role_ = message.role;
  if (!message.scene) return;
  description_ = message.scene;
  ++descriptions_;
  newest_shape_ = nullptr;  // of another scene
}

void StateLink::take(const StateReply& message, const Arrival& arrival) {
  if ((message.number & kLookBack) != 0) {
    looked_back_.push_back(message);
    looked_back_.back().number &= ~kLookBack;
    return;
  }
  const RequestTracker::Noted noted = request_tracker_.reply(message.number, message.answer.kind);
  if (!noted.first) return;
  arrived_.push_back({message, noted.sent, arrival.received, noted.newest});
  if (noted.newest) newest_ = arrived_.back();
  // Of the size that was announced, so that whoever draws it need not look again.
  if (noted.newest && message.shape && description_ &&
      message.shape->vertices() == description_->shape_vertices)
    newest_shape_ = message.shape;
}

void StateLink::take(const SyncReply& message, const Arrival& arrival) {
  auto t1 = arrival.asked;
  if (!t1) {
    SentSync& sent = syncs_sent_[message.number / LinkWire::kSyncTrain % syncs_sent_.size()];
    if (message.number == 0 || sent.number != message.number) return;  // twice, or long forgotten
    sent.number = 0;
    t1 = sent.t1;
  }
  if (syncs_done_.size() >= kMaxSyncsKept) syncs_done_.pop_front();
  syncs_done_.push_back({*t1, message.t2, message.t3, arrival.received});
}

void StateLink::take(const ControlReply& message, const Arrival&) {
  if (pending_.empty() || pending_.front().call.number != message.number) return;
  pending_.pop_front();
  if (!message.refusal.empty()) {
    refusal_ = message.refusal;
    ++controls_dropped_;
  }
  send_pending(wire_->now());
}

bool StateLink::ask_status() { return send(StatusRequest{++statuses_}).has_value(); }

void StateLink::take(const StatusReply& message, const Arrival&) {
  status_ = message.status;
  ++statuses_come_;
}

void StateLink::take(const Refusal& message, const Arrival&) { refusal_ = message.reason; }

bool StateLink::peer_alive() const {
  if (!last_word_) return false;
  return !unanswered_since_ || wire_->now() - *unanswered_since_ <= kGoneAfter;
}

std::optional<Duration> StateLink::since_last_word() const {
  if (!last_word_) return std::nullopt;
  return wire_->now() - *last_word_;
}

}  // namespace palpate::transport
