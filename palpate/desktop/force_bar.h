// The force that a hand on the arm would feel, for a person who has none: a bar that jumps up with a force,
// holds its peak long enough to be read, and falls.
//
// Newtons and seconds of any steady clock. Pure; one thread.
#pragma once

namespace palpate::desktop {

class ForceBar {
 public:
  static constexpr double kHold_s = 0.35;  // the peak stands
  static constexpr double kFall_s = 0.25;  // then falls to 1/e in this time

  // The force at `t`, or the largest since the last call.
  void feel(double t, double newton);

  double level(double t) const;               // N, what the bar shows
  double last_peak() const { return peak_; }  // N, of the latest rise
  // Where something is felt now or has just been.
  bool shows(double t) const { return level(t) > 0.02 * peak_; }

 private:
  double peak_ = 0.0, at_ = -1e9;
};

}  // namespace palpate::desktop
