// Ctrl-C and SIGTERM as a flag that loops look at, so that servers end in order.
#pragma once

#include <atomic>
#include <csignal>

namespace palpate::inline core {

// Installs the handlers once and returns the flag. Any thread may look.
inline const std::atomic<bool>& stop_requested() {
  static std::atomic<bool> stop{false};
  static const bool installed = [] {
    struct sigaction action {};
    action.sa_handler = [](int) { stop.store(true, std::memory_order_relaxed); };
    ::sigaction(SIGINT, &action, nullptr);
    ::sigaction(SIGTERM, &action, nullptr);
    return true;
  }();
  (void)installed;
  return stop;
}

}  // namespace palpate::inline core
