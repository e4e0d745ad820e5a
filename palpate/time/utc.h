// The time of day that files and viewers are dated with. Any thread; it may be set while a program runs.
#pragma once

#include <chrono>
#include <cstdint>

namespace palpate::inline time {

// ns since 1970.
inline std::int64_t utc_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace palpate::inline time
