// Tells a peer that has died from one that merely stood still together with this process, as both do while a
// virtual machine is paused or a laptop sleeps. Times in ns of one clock that both read; for one thread.
#pragma once

#include <algorithm>
#include <cstdint>

namespace palpate::device {

class HeartbeatMonitor {
 public:
  // `allowed_ns`: a peer without a beat for so long is gone.
  explicit HeartbeatMonitor(std::int64_t allowed_ns) : allowed_ns_(allowed_ns) {}

  // Whether the peer, last heard of at `beat_ns`, is gone. Where nobody has looked for half of the allowed
  // time, this process stood still, and a peer that was there before gets the allowed time anew. Three times
  // for one sign of life: whoever looks rarely because the machine is slow has used up one before the pause.
  bool gone(std::int64_t now_ns, std::int64_t beat_ns) {
    const bool stood_still = looked_ns_ != 0 && now_ns - looked_ns_ > allowed_ns_ / 2;
    looked_ns_ = now_ns;
    if (beat_ns != forgiven_beat_ns_) forgiven_beat_ns_ = beat_ns, forgiven_ = 0;
    if (stood_still && !gone_ && forgiven_ < kMostForgiven) resumed_ns_ = now_ns, ++forgiven_;
    gone_ = now_ns - std::max(beat_ns, resumed_ns_) >= allowed_ns_;
    return gone_;
  }

 private:
  static constexpr int kMostForgiven = 3;
  std::int64_t allowed_ns_, looked_ns_ = 0, resumed_ns_ = 0, forgiven_beat_ns_ = 0;
  int forgiven_ = 0;
  bool gone_ = false;
};

}  // namespace palpate::device
