// Waits for what must come, however long a busy machine takes. For tests only.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace palpate::drivers::network {

inline bool comes_true(const std::function<bool()>& condition) {
  for (int i = 0; i < 12'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

}  // namespace palpate::drivers::network
