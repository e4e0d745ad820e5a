// Who gets states by themselves: a subscription for each connection, its lease and its next state.
//
// Bookkeeping alone, without wire and thread; one thread. A subscription lasts kLease from its last renewal.
// How many there are and how many states a second they cost is bounded, in all and for each key, so that no
// observer can take the place of the others.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/time/instant.h"

namespace palpate::transport {

class Subscriptions {
 public:
  static constexpr Duration kLease = std::chrono::seconds(3);
  static constexpr std::size_t kMost = 128, kMostOfKey = 32;
  static constexpr int kMostStates_hz = 32'000, kMostStatesOfKey_hz = 8'000;  // of all rates together

  // The connection `peer` gets `rate_hz` (above 0) states a second from now on, in place of what it had.
  // `key`: of its observer, empty where the connection is not encrypted; then the bounds of a key do not
  // hold. Refused, in words for the observer, beyond the bounds; what it had goes on.
  Expected<void> renew(const std::string& peer, const std::string& key, int rate_hz,
                       Instant<PhysicsClock> now);
  void drop_lapsed(Instant<PhysicsClock> now);
  void keep_only(const std::function<bool(const std::string& key)>& admitted);

  // Calls `send` for each that is due, with the number of its state (1, 2, ...). Returns of `send`: false =
  // the connection has gone, and the subscription with it.
  using Send = std::function<bool(const std::string& peer, std::uint64_t number)>;
  void for_each_due(Instant<PhysicsClock> now, const Send& send);
  std::optional<Instant<PhysicsClock>> next_due() const;
  std::size_t size() const { return subscriptions_.size(); }

 private:
  struct Subscription {
    std::string key;
    int rate_hz = 0;
    Instant<PhysicsClock> due, until;
    std::uint64_t number = 0;  // of the last state
  };
  std::map<std::string, Subscription> subscriptions_;  // by connection
};

}  // namespace palpate::transport
