// How many messages of one connection are looked at; the rest is passed over, which is so much cheaper that no
// queue grows. Where many connections say much, each has its part of what the thread can answer. A connection
// that sends far more than that is a flood, and has to end: what it has sent lies in this process's memory until
// it has been passed over. One thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>

#include "palpate/time/instant.h"

namespace palpate::transport {

class RateLimit {
 public:
  enum class Share { within, beyond, flood };  // flood: from here on, said once

  // Of a connection in a tenth of a second: one that asks again as soon as it is answered, and one that was held
  // up for seconds and then says all at once what it had to say, send less.
  static constexpr std::size_t kFloodBytes = 512 << 10;
  static constexpr std::size_t kBytesPerMessage = 128;  // that a message takes beside what it says
  // A message counts once for each of these: the work is in what is read, and questions are short.
  static constexpr std::size_t kBytesThatCountOnce = 100;

  // Of one connection, and of all together.
  RateLimit(int messages_hz, int together_hz) : most_(messages_hz / 10), together_(together_hz / 10) {}

  // Counts one more message of the connection `peer`.
  Share count(const std::string& peer, std::size_t bytes, Instant<PhysicsClock> now) {
    const std::int64_t window = now.ns() / 100'000'000;
    if (window != window_) {
      before_ = window == window_ + 1 ? sent_.size() : 0;
      sent_.clear();
    }
    window_ = window;
    Sent& sent = sent_[peer];
    sent.bytes += bytes + kBytesPerMessage;
    sent.messages += 1 + static_cast<int>(bytes / kBytesThatCountOnce);
    if (sent.bytes > kFloodBytes) return std::exchange(sent.flood, true) ? Share::beyond : Share::flood;
    const auto speaking = static_cast<int>(std::max(before_, sent_.size()));
    return sent.messages <= std::min(most_, together_ / speaking) ? Share::within : Share::beyond;
  }

 private:
  struct Sent {
    int messages = 0;
    std::size_t bytes = 0;
    bool flood = false;
  };
  int most_, together_;
  std::int64_t window_ = 0;
  std::size_t before_ = 0;                      // connections that spoke in the window before
  std::unordered_map<std::string, Sent> sent_;  // in this window, by connection
};

}  // namespace palpate::transport
