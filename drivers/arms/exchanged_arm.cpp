#include "drivers/arms/exchanged_arm.h"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/time/real_time.h"

namespace palpate::drivers::arms {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = 1ms, kRetry = 500ms;
constexpr int kPriority = 70;        // below the haptic loop's, above ordinary threads
constexpr double kMeanShare = 1e-3;  // of the newest round trip in their mean

}  // namespace

ExchangedArm::ExchangedArm(ExchangedArmSettings settings, ConnectArm connect)
    : settings_(std::move(settings)), connect_(std::move(connect)), mailbox_(settings_.loop) {}

Expected<std::unique_ptr<ExchangedArm>> ExchangedArm::open(ExchangedArmSettings settings,
                                                           ConnectArm connect) {
  std::unique_ptr<ExchangedArm> arm(new ExchangedArm(std::move(settings), std::move(connect)));
  // By the thread that goes on with it: what it takes to start one would be a first outage.
  std::promise<Expected<void>> first;
  auto connected = first.get_future();
  arm->thread_ =
      std::thread([raw = arm.get(), first = std::move(first)]() mutable { raw->run(std::move(first)); });
  if (auto outcome = connected.get(); !outcome) return tl::unexpected(outcome.error());
  return arm;
}

ExchangedArm::~ExchangedArm() {
  {
    const std::lock_guard lock(sleep_guard_);
    ending_ = true;
  }
  sleep_.notify_all();
  if (thread_.joinable()) thread_.join();
}

Expected<void> ExchangedArm::connect() {
  auto link = connect_();
  if (!link) return tl::unexpected(link.error());
  link_ = std::move(*link);
  sampled_ns_.reset();
  may_push_ = false;
  mailbox_.start(now_ns());
  // No force yet: nothing is known of the device before.
  if (auto told = exchange(); !told) {
    link_.reset();
    return told;
  }
  mailbox_.set_lost(false);
  return {};
}

void ExchangedArm::run(std::promise<Expected<void>> first) {
  name_and_pin_thread(settings_.thread_name.c_str(), -1);
  if (!enter_real_time(kPriority).fifo()) sharpen_sleep();
  auto connected = connect();
  const bool there = connected.has_value();
  first.set_value(std::move(connected));
  if (!there) return;
  auto due = std::chrono::steady_clock::now();
  while (true) {
    if (!link_) {
      if (wait_until(std::chrono::steady_clock::now() + kRetry)) return;
      if (const auto again = connect(); !again) lose(again.error());
      due = std::chrono::steady_clock::now();
      continue;
    }
    if (const auto exchanged = exchange(); !exchanged) {
      link_.reset();
      times_lost_.fetch_add(1);
      lose(exchanged.error());
      continue;
    }
    due = std::max(due + kPeriod, std::chrono::steady_clock::now());
    if (wait_until(due)) return;
  }
}

bool ExchangedArm::wait_until(std::chrono::steady_clock::time_point time) {
  std::unique_lock lock(sleep_guard_);
  return sleep_.wait_until(lock, time, [this] { return ending_; });
}

void ExchangedArm::lose(const Error& error) {
  const std::lock_guard lock(words_guard_);
  trouble_ = error.message;
  mailbox_.set_lost(true);
}

Expected<void> ExchangedArm::exchange() {
  const std::int64_t begun = now_ns();
  const Vector3 force = mailbox_.force_now(begun, may_push_, sampled_ns_);
  const auto state = link_->exchange(force);
  if (!state) return tl::unexpected(state.error());
  mailbox_.tell_held(begun, force, state->held);
  may_push_ = state->may_push && state->knows_its_place;
  complaint_.store(state->complaint);
  if (state->knows_its_place) {
    sampled_ns_ = state->reading.stamp_ns;
    mailbox_.put(state->reading);
  }
  const double took = seconds_between(begun, now_ns()), mean = round_trip_s_.load();
  round_trip_s_.store(mean == 0.0 ? took : mean + kMeanShare * (took - mean));
  exchanges_.fetch_add(1, std::memory_order_relaxed);
  return {};
}

ExchangedArmStatus ExchangedArm::status() const {
  ExchangedArmStatus status;
  status.exchanges = exchanges_.load();
  status.stale_exchanges = mailbox_.stale_forces();
  status.refused_commands = mailbox_.refused_commands();
  status.times_lost = times_lost_.load();
  status.round_trip_s = round_trip_s_.load();
  const auto is = [&](device::HealthCode code, const std::string& words) {
    status.health = {code, fmt::format("{}: {}", settings_.name, words), settings_.name + ": works again"};
  };
  if (mailbox_.is_lost()) {
    const std::lock_guard lock(words_guard_);
    is(device::HealthCode::arm_lost, trouble_);
    status.health->end +=
        "; see that it still knows where it is, then `palpate status --reset` lets forces come back";
  } else if (const Complaint* complaint = complaint_.load(); complaint != nullptr) {
    is(complaint->code, complaint->words);
  }
  return status;
}

}  // namespace palpate::drivers::arms
