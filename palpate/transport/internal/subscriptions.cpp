#include "palpate/transport/internal/subscriptions.h"

#include <algorithm>

namespace palpate::transport {
namespace {

// On a grid that all of one rate share, so that many observers cost few wake-ups. What was slept over is not
// made up for.
Instant<PhysicsClock> after(Instant<PhysicsClock> now, int rate_hz) {
  const std::int64_t period = 1'000'000'000 / rate_hz;
  const std::int64_t past = (now.ns() % period + period) % period;
  return now + Duration(period - past);
}

}  // namespace

Expected<void> Subscriptions::renew(const std::string& peer, const std::string& key, int rate_hz,
                                    Instant<PhysicsClock> now) {
  std::size_t of_key = 0;
  int states_hz = rate_hz, states_of_key_hz = rate_hz;
  for (const auto& [other, subscription] : subscriptions_) {
    if (other == peer) continue;
    states_hz += subscription.rate_hz;
    if (key.empty() || subscription.key != key) continue;
    ++of_key;
    states_of_key_hz += subscription.rate_hz;
  }
  const auto known = subscriptions_.find(peer);
  const bool fits = key.empty() || (of_key < kMostOfKey && states_of_key_hz <= kMostStatesOfKey_hz);
  if (!fits || (known == subscriptions_.end() && size() >= kMost) || states_hz > kMostStates_hz)
    return refused(
        "too many subscriptions; this server takes {} with {} states a second together, of them {} with {} "
        "of the same key",
        kMost, kMostStates_hz, kMostOfKey, kMostStatesOfKey_hz);
  Subscription& subscription = known == subscriptions_.end() ? subscriptions_[peer] : known->second;
  if (subscription.rate_hz != rate_hz) subscription.due = now;
  subscription.key = key;
  subscription.rate_hz = rate_hz;
  subscription.until = now + kLease;
  return {};
}

void Subscriptions::drop_lapsed(Instant<PhysicsClock> now) {
  std::erase_if(subscriptions_, [now](const auto& one) { return one.second.until < now; });
}

void Subscriptions::keep_only(const std::function<bool(const std::string& key)>& admitted) {
  std::erase_if(subscriptions_, [&](const auto& one) { return !admitted(one.second.key); });
}

void Subscriptions::for_each_due(Instant<PhysicsClock> now, const Send& send) {
  for (auto one = subscriptions_.begin(); one != subscriptions_.end();) {
    Subscription& subscription = one->second;
    const bool due = subscription.due <= now;
    if (due) subscription.due = after(now, subscription.rate_hz);
    one = due && !send(one->first, ++subscription.number) ? subscriptions_.erase(one) : std::next(one);
  }
}

std::optional<Instant<PhysicsClock>> Subscriptions::next_due() const {
  std::optional<Instant<PhysicsClock>> next;
  for (const auto& [peer, subscription] : subscriptions_)
    next = next ? std::min(*next, subscription.due) : subscription.due;
  return next;
}

}  // namespace palpate::transport
