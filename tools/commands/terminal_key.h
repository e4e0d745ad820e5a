// The space bar of this terminal as a key that is held: it counts as held while the terminal repeats it.
//
// A terminal tells no release: the key counts as released when no repeat has come for 150 ms, and 800 ms after it was first
// pressed, which is when terminals begin to repeat. A stylus button is quicker. q: no more. One object at a time; held() and quit()
// from any thread. Refused: standard input is no terminal.
#pragma once

#include <termios.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include "palpate/core/expected.h"

namespace palpate::tools::commands {

class TerminalKey {
 public:
  static Expected<std::unique_ptr<TerminalKey>> open();
  ~TerminalKey();  // the terminal as it was
  bool held() const;
  bool quit() const { return quit_.load(std::memory_order_relaxed); }

 private:
  explicit TerminalKey(const termios& before);
  void listen();

  termios before_;
  std::atomic<std::int64_t> until_ns_{0};
  std::atomic<bool> ending_{false}, quit_{false};
  std::thread thread_;
};

}  // namespace palpate::tools::commands
