// Ctrl-C and SIGTERM as a flag that loops look at, so that servers end in order.
#pragma once

#include <atomic>
#include <cerrno>
#include <csignal>
#include <system_error>

namespace palpate::inline core {

// Throws std::system_error where the signal cannot be handled.
inline void handle_signal(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  if (::sigaction(signal, &action, nullptr) != 0)
    throw std::system_error(errno, std::generic_category(), "a signal handler cannot be installed");
}

namespace stop_signal {
inline std::atomic<bool> flag{false};
}

// Installs the handlers once and returns the flag. Any thread may look.
inline const std::atomic<bool>& stop_requested() {
  static const bool installed = [] {
    for (const int signal : {SIGINT, SIGTERM})
      handle_signal(signal, [](int) { stop_signal::flag.store(true, std::memory_order_relaxed); });
    return true;
  }();
  (void)installed;
  return stop_signal::flag;
}

// The same where a program may never have asked for the handlers: then a signal ends it at once.
inline bool told_to_stop() { return stop_signal::flag.load(std::memory_order_relaxed); }

}  // namespace palpate::inline core
