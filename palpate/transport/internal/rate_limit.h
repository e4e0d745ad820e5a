// How many messages of one connection are looked at; the rest of a flood is passed over, which is so much
// cheaper that no queue grows. One thread.
#pragma once

#include <string>
#include <unordered_map>

#include "palpate/time/instant.h"

namespace palpate::transport {

class RateLimit {
 public:
  explicit RateLimit(int messages_hz) : most_(messages_hz / 10) {}

  // Counts one more of the connection `peer`; false where it has had its share of this tenth of a second.
  bool admits(const std::string& peer, Instant<PhysicsClock> now) {
    const std::int64_t window = now.ns() / 100'000'000;
    if (window != window_) counts_.clear();
    window_ = window;
    return ++counts_[peer] <= most_;
  }

 private:
  int most_;
  std::int64_t window_ = 0;
  std::unordered_map<std::string, int> counts_;  // in this window, by connection
};

}  // namespace palpate::transport
