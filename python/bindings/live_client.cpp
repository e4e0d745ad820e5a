#include "python/bindings/live_client.h"

#include <algorithm>

#include "palpate/core/text.h"
#include "palpate/time/real_time.h"

namespace palpate::python {
namespace {

constexpr Duration kBusyTurn = std::chrono::milliseconds(1), kIdleTurn = std::chrono::milliseconds(20);
constexpr Duration kLookEvery = std::chrono::milliseconds(5);
constexpr Duration kAskAgainAfter = std::chrono::milliseconds(250);

}  // namespace

Expected<std::shared_ptr<LiveClient>> LiveClient::connect(const transport::ServerName& server,
                                                          std::string name) {
  auto place = transport::server_place(server);
  if (!place) return tl::unexpected(place.error());
  auto client = std::make_shared<LiveClient>(std::move(*place));
  auto link = transport::connect_states(client->place_.endpoint, client->clock_, std::move(name),
                                        client->place_.identity);
  if (!link) return tl::unexpected(link.error());
  client->link_ = std::move(*link);
  client->thread_ = std::thread([self = client.get()] { self->run(); });
  return client;
}

void LiveClient::close() {
  std::thread thread;
  std::unique_ptr<transport::StateLink> link;
  std::vector<std::shared_ptr<LiveWatch>> watches;
  {
    const std::lock_guard lock(mutex_);
    link = std::move(link_);
    watches = std::move(watches_);
    steps_.clear();
    thread = std::move(thread_);
  }
  due_.notify_all();
  come_.notify_all();
  for (const auto& watch : watches) watch->end();
  if (thread.joinable()) thread.join();
}

bool LiveClient::closed() const {
  const std::lock_guard lock(mutex_);
  return link_ == nullptr;
}

void LiveClient::run() {
  name_and_pin_thread("palpate-client", -1);
  std::unique_lock lock(mutex_);
  while (link_) {
    turn();
    come_.notify_all();
    due_.wait_for(lock, busy() ? kBusyTurn : kIdleTurn);
  }
}

bool LiveClient::busy() const {
  return !questions_.empty() || !steps_.empty() || !link_->description() || link_->controls_waiting() > 0;
}

void LiveClient::turn() {
  link_->poll();
  const auto now = clock_.now();
  const bool other = std::exchange(session_, link_->session()) != link_->session();
  if (other)
    for (const auto& steps : steps_) steps->other_session();
  for (const auto& reply : link_->looked_back()) {
    const auto question = questions_.find(reply.number);
    if (question != questions_.end()) question->second.reply = reply;
    // What comes with a new session may be of the one before.
    if (!other)
      for (const auto& steps : steps_) steps->answer(reply, now.since_epoch);
  }
  for (auto& [number, question] : questions_)
    if (!question.reply && now - question.asked > kAskAgainAfter) send(number, question);
  if (now - looked_ >= kLookEvery) {
    looked_ = now;
    for (const auto& steps : steps_) steps->look(*link_, number_, now.since_epoch);
  }
  keep_clock(now);
}

void LiveClient::keep_clock(Instant<GraphicsClock> now) {
  if ((!synced_ || now - *synced_ >= sync_.interval()) && link_->send_sync()) synced_ = now;
  while (const auto stamps = link_->take_sync()) sync_.add(stamps->t1, stamps->t2, stamps->t3, stamps->t4);
}

void LiveClient::wait(Duration patience) {
  std::unique_lock lock(mutex_);
  if (link_) come_.wait_for(lock, patience);
}

ServerFacts LiveClient::facts() const {
  const std::lock_guard lock(mutex_);
  if (!link_) return {};
  ServerFacts facts{link_->description(), link_->session(), link_->role(), link_->peer_alive(), {}};
  if (const auto trouble = link_->trouble())
    facts.trouble = "it turns us away: " + *trouble;
  else if (const auto refusal = link_->refusal())
    facts.trouble = "it refuses: " + excerpt(*refusal, 200);
  return facts;
}

ClockFacts LiveClient::clock() const {
  const std::lock_guard lock(mutex_);
  return {sync_.model(), sync_.phase(), to_seconds(sync_.lowest_round_trip())};
}

void LiveClient::send(std::uint64_t number, Question& question) {
  question.asked = clock_.now();
  link_->look_back(number, question.time.value_or(scene::StepReader::kFarAhead));
}

std::uint64_t LiveClient::ask(std::optional<Time> time) {
  const std::lock_guard lock(mutex_);
  auto& question = questions_[++number_];
  question.time = time;
  if (link_) send(number_, question);
  due_.notify_all();
  return number_;
}

std::optional<transport::StateReply> LiveClient::answer(std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  const auto question = questions_.find(number);
  return question == questions_.end() ? std::nullopt : question->second.reply;
}

void LiveClient::forget(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  questions_.erase(number);
}

bool LiveClient::send_control(scene::Control control) {
  const std::lock_guard lock(mutex_);
  due_.notify_all();
  return link_ && link_->send_control(control);
}

std::size_t LiveClient::controls_waiting() const {
  const std::lock_guard lock(mutex_);
  return link_ ? link_->controls_waiting() : 0;
}

std::uint64_t LiveClient::controls_dropped() const {
  const std::lock_guard lock(mutex_);
  return link_ ? link_->controls_dropped() : 0;
}

std::shared_ptr<StepQueue> LiveClient::begin_steps() {
  const std::lock_guard lock(mutex_);
  auto steps = std::make_shared<StepQueue>();
  if (link_) steps_.push_back(steps);
  due_.notify_all();
  return steps;
}

void LiveClient::end_steps(const std::shared_ptr<StepQueue>& steps) {
  const std::lock_guard lock(mutex_);
  std::erase(steps_, steps);
}

std::optional<StepBlock> LiveClient::take_steps(StepQueue& steps, Duration span) {
  const std::lock_guard lock(mutex_);
  return steps.take(span, clock_.now().since_epoch);
}

Expected<std::shared_ptr<LiveWatch>> LiveClient::begin_watch(int rate_hz) {
  auto watch = transport::watch_states(place_.endpoint, rate_hz, place_.identity);
  if (!watch) return tl::unexpected(watch.error());
  auto begun = std::make_shared<LiveWatch>(std::move(*watch));
  const std::lock_guard lock(mutex_);
  if (link_)
    watches_.push_back(begun);
  else
    begun->end();
  return begun;
}

void LiveClient::end_watch(const std::shared_ptr<LiveWatch>& watch) {
  watch->end();
  const std::lock_guard lock(mutex_);
  std::erase(watches_, watch);
}

std::optional<transport::StateReply> LiveWatch::take() {
  const std::lock_guard lock(mutex_);
  if (!watch_) return std::nullopt;
  auto reply = watch_->take();
  counters_ = watch_->counters();
  return reply;
}

std::optional<std::string> LiveWatch::refusal() const {
  const std::lock_guard lock(mutex_);
  return watch_ ? watch_->refusal() : std::nullopt;
}

transport::StateWatch::Counters LiveWatch::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

void LiveWatch::end() {
  const std::lock_guard lock(mutex_);
  watch_.reset();
}

}  // namespace palpate::python
