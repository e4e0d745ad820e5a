#include "tools/commands/terminal_key.h"

#include <poll.h>
#include <unistd.h>

#include "palpate/time/clock.h"

namespace palpate::tools::commands {
namespace {

constexpr std::int64_t kRepeatNs = 150'000'000, kFirstNs = 800'000'000;

std::int64_t now_ns() { return MonotonicClock<PhysicsClock>::monotonic_ns(); }

}  // namespace

Expected<std::unique_ptr<TerminalKey>> TerminalKey::open() {
  termios before{};
  if (isatty(STDIN_FILENO) == 0 || tcgetattr(STDIN_FILENO, &before) != 0)
    return wrong_use(
        "standard input is no terminal whose space bar could be held; --key-button N takes a button of the "
        "stylus, --yes-held counts the key as held throughout");
  return std::unique_ptr<TerminalKey>(new TerminalKey(before));
}

TerminalKey::TerminalKey(const termios& before) : before_(before) {
  termios raw = before;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  thread_ = std::thread([this] { listen(); });
}

TerminalKey::~TerminalKey() {
  ending_.store(true);
  thread_.join();
  tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
}

bool TerminalKey::held() const { return now_ns() < until_ns_.load(std::memory_order_relaxed); }

void TerminalKey::listen() {
  bool repeats = false;
  while (!ending_.load()) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, 20) > 0) {
      char key = 0;
      if (read(STDIN_FILENO, &key, 1) != 1) return;
      if (key == ' ') {
        repeats = held();
        until_ns_.store(now_ns() + (repeats ? kRepeatNs : kFirstNs), std::memory_order_relaxed);
      } else {
        until_ns_.store(0, std::memory_order_relaxed);  // any other key lets go
        if (key == 'q' || key == 'Q') quit_.store(true, std::memory_order_relaxed);
      }
    }
  }
}

}  // namespace palpate::tools::commands
