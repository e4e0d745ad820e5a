// Two descriptions of a scene compared, in plain words: what pictures of the one would get wrong of the other, and
// whether both sides' rigs say the same of the real surfaces and of the arm. Names come from another machine and are shown as excerpts.
// Pure; any thread.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpate/scene/application.h"

namespace palpate::scene {

// What `played` is that pictures made for `drawn` do not show: its name, "cups, not balls"; "balls with 3 bodies, not 2".
// None: they fit. The rig has its own comparison; what a body weighs is not seen.
std::optional<std::string> other_than_drawn(const SceneDescription& drawn, const SceneDescription& played);

struct RigComparison {
  // Farther apart than a calibration repeated on the same things leaves them; and so far that a hand feels things
  // where its eyes do not see them.
  static constexpr double kSame = 0.002, kElsewhere = 0.02;  // m

  double largest = 0.0;  // m, between corners of the same name and number
  std::string farthest;  // the surface that has it; empty: all lie in the same places
  std::vector<std::string> only_here, only_there;
  double arm = 0.0;  // m, between the tips that equal readings give; 0 where one side says nothing of its arm
  bool other_arm = false;  // of another number of joints

  bool agree() const {
    return largest <= kSame && arm <= kSame && !other_arm && only_here.empty() && only_there.empty();
  }
  bool elsewhere() const { return largest > kElsewhere || arm > kElsewhere || other_arm; }
  // What differs, without a remedy: "'table' lies 300 mm from where it lies here, 'wall' is missing there".
  std::string words() const;
};

// Of both descriptions, what the rig tells: surfaces and arm.
RigComparison compare_rigs(const SceneDescription& here, const SceneDescription& there);

}  // namespace palpate::scene
