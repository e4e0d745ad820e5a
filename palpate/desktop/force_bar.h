// The force that a hand on the arm would feel, for a person who has none: a bar that jumps up with a force,
// holds its peak long enough to be read, and falls. A force that lasts it shows as it is.
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

  // The force that lasts, from now on; 0: none.
  void last(double newton) { lasting_ = newton; }

  double level(double t) const;  // N, what the bar shows
  // N, of the latest rise, or what lasts.
  double last_peak() const { return lasting_ > 0.0 ? lasting_ : peak_; }
  // Where something is felt now or has just been.
  bool shows(double t) const { return level(t) > 0.02 * last_peak(); }

 private:
  double peak_ = 0.0, at_ = -1e9, lasting_ = 0.0;
};

}  // namespace palpate::desktop
