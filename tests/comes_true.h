// Waits for what must come, however long a busy machine or a sanitizer takes over what ought to take milliseconds.
#pragma once

#include <chrono>
#include <thread>

namespace palpate::tests {

template <typename Condition>
bool comes_true(Condition condition) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace palpate::tests
