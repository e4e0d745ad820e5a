// How strong forces may be while they fade and come back: one rule for every loop that commands a motor.
//
// An outage begins `stale_s` after the last good reading, input or tick, in real time. While it lasts forces
// fade. After a brief one they come back within `return_s`, from what the device still gives; after a longer
// one the first command is 0, and forces come back along the start ramp. All times are those that have really
// passed, however late a tick is. Value; one thread; no allocation. docs/theory/forces.md.
#pragma once

#include <algorithm>
#include <limits>

namespace palpate::device {

class ForceStrength {
 public:
  struct Settings {
    double stale_s = 0.005;   // no fresh reading, input or tick for so long: an outage begins
    double fade_s = 0.015;    // from full strength to none
    double brief_s = 0.050;   // an outage of at most so long is brief
    double return_s = 0.040;  // from none to what there was before a brief one
    double ramp_s = 1.0;      // from none to full strength, at the start and after a longer one; 0: at once
  };
  explicit ForceStrength(const Settings& settings) : settings_(settings) {}

  // Once a tick. `good`: forces may be given. `age_s`: since the oldest of what has to be fresh was, at a
  // tick that is not good. `elapsed_s`: since the tick before. `held`: the share of the last command that the
  // device still gave when this tick began.
  void tick(bool good, double age_s, double elapsed_s, double held = 1.0) {
    const bool late = !(elapsed_s < settings_.stale_s);
    if (late) {
      share_ *= std::clamp(held, 0.0, 1.0);
      outage_s_ = out_ ? outage_s_ + elapsed_s : elapsed_s - settings_.stale_s;
    } else if (out_) {
      outage_s_ += elapsed_s;
    } else if (!good) {
      outage_s_ = age_s - settings_.stale_s;
    }
    const bool was_out = out_ || late;
    out_ = !good;
    if (!good) {
      share_ = std::max(0.0, share_ - elapsed_s / settings_.fade_s);
      if (share_ < 1e-12) share_ = 0.0;  // what rounding leaves of n steps of 1/n
    } else if (was_out) {
      // From what is held now; the first step up is the next tick's.
      if (!brief()) begin_ramp();
      good_s_ = 0.0;
    } else {
      good_s_ += elapsed_s;
      ramp_ = settings_.ramp_s > 0.0 ? std::min(1.0, ramp_ + elapsed_s / settings_.ramp_s) : 1.0;
      share_ = std::min(1.0, share_ + elapsed_s / settings_.return_s);
    }
  }
  // The device gives nothing any more: not to be gone on from.
  void let_go() { share_ = 0.0; }
  // No force; the next good tick begins the start ramp.
  void restart() {
    let_go();
    out_ = true;
    outage_s_ = std::numeric_limits<double>::infinity();
  }

  double gain() const { return ramp_ * share_; }  // 0 = off, 1 = full strength
  double share() const { return share_; }         // of what there was before the outage
  bool out() const { return out_; }
  // Of the outage under way, or of the last one; 0 or less: it was over before it had begun.
  double outage_s() const { return outage_s_; }
  bool brief() const { return outage_s_ <= settings_.brief_s + kRounding; }
  double good_s() const { return good_s_; }  // since forces may be given again

 private:
  void begin_ramp() {
    ramp_ = settings_.ramp_s > 0.0 ? 0.0 : 1.0;
    share_ = 1.0;
  }

  static constexpr double kRounding = 1e-9;  // s, of adding up ticks

  Settings settings_;
  bool out_ = true;
  double good_s_ = 0.0;
  double ramp_ = 0.0, share_ = 1.0;
  double outage_s_ = std::numeric_limits<double>::infinity();
};

}  // namespace palpate::device
