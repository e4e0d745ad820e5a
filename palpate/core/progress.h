// Progress of a long command, for a person: phases, a bar and the time left, on standard error, only on a
// terminal.
//
// One thread. Silent when standard error is a file or a pipe, so that logs stay clean.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace palpate::inline core {

class Progress {
 public:
  struct Phase {
    std::string name;
    double expected_s;  // share of the whole, measured once on an ordinary machine; only ratios matter
  };
  explicit Progress(std::vector<Phase> phases);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin(std::size_t phase);
  // Share of the current phase that is done, 0 ... 1.
  void update(double share);
  // Shown beside the bar instead of the phase's name, until the next phase begins.
  void say(std::string what);
  // Removes the bar; later calls draw nothing.
  void finish();

  // False where no bar is drawn: a long command then says otherwise what it does.
  bool on_terminal() const { return on_terminal_; }
  // Share of the whole that is done.
  double share() const;

 private:
  void draw(bool force);

  using Clock = std::chrono::steady_clock;
  std::vector<Phase> phases_;
  std::string said_;
  double total_ = 0.0, before_ = 0.0, share_ = 0.0;
  std::size_t phase_ = 0;
  bool on_terminal_ = false, drawn_ = false;
  Clock::time_point start_, last_draw_;
};

// "1:05 left" or "12 s left".
std::string time_left_text(double seconds);

}  // namespace palpate::inline core
