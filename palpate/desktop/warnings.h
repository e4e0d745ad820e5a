// What is wrong with a running system, in words for the person in front of the picture.
//
// A warning comes when its cause has lasted a moment, so that one lost sample says nothing, and goes by
// itself a moment after its cause has gone. Each cause is told within 0.5 s of its beginning: kTold_s is the
// longest of the waits here, and whoever draws does so at least ten times a second. What is wrong with camera
// and tracker is judged by the graphics server (palpate/server/graphics/conditions.h) and shown in its words
// at once. Seconds of any steady clock. Pure; one thread.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "palpate/device/force_condition.h"

namespace palpate::desktop {

// How the system stands at a moment.
struct Standing {
  std::vector<std::string> devices;              // what is wrong with them, the oldest first
  double since_physics_s = 0.0;                  // since the physics server's last word
  double late_share = 0.0;                       // of the last second's pictures, drawn with the state before
  bool state_old = false;                        // the history no longer held what was asked for
  std::optional<device::ForceCondition> forces;  // of the haptic loop; none: not known
  std::string culprit;                           // the application that has brought it about; empty: none
  std::string failure;  // what has become of the application, for good; empty: nothing
  bool felt = true;     // by somebody's hand; a mouse has no force
  std::string refusal;  // why the physics server does not do as it is asked; empty: it does
};

enum class Trouble { device, physics, late, old, forces, refusal };

struct Warning {
  Trouble trouble = Trouble::device;
  std::string words;
};

class Warnings {
 public:
  static constexpr double kTold_s = 0.4;
  static constexpr double kPhysicsSilent_s = 0.35;
  static constexpr double kLateShare = 0.3;

  void look(double now, const Standing& standing);
  // Those that stand, the most important first.
  std::vector<Warning> shown() const;

 private:
  struct One {
    std::optional<double> since, gone_since;
    bool shown = false;
    std::string words;
  };
  void judge(Trouble trouble, double now, bool wrong, double wait_s, std::string words);
  std::vector<std::string> devices_;
  std::array<One, 6> all_;
};

}  // namespace palpate::desktop
