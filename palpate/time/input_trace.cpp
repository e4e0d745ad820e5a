#include "palpate/time/input_trace.h"

#include <algorithm>

namespace palpate::inline time {

void InputTrace::play(std::span<const std::uint64_t> values, InputPlayback& playback) noexcept {
  count_ = std::min(values.size(), kMost);
  exact_ = values.size() <= kMost;
  std::copy_n(values.begin(), count_, values_.begin());
  position_ = 0;
  playback_ = &playback;
}

}  // namespace palpate::inline time
