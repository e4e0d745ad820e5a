// How hard a search is, where a staircase makes it so: levels between the two ends of the settings' sizes and depths, and
// the rule that leads from one to the next. Values; one thread.
#pragma once

#include "applications/palpation/settings.h"
#include "palpate/experiment/staircase.h"

namespace palpate::applications::palpation {

// The largest nodules at the least depth at level 0, the smallest at the greatest depth at the hardest, evenly in between;
// what else is drawn does not depend on the level. Any other number is taken for the nearest level there is.
NoduleRanges ranges_at(const NoduleRanges& scale, int level);

// How a search answers: positively where every nodule was found without a false alarm.
constexpr bool answers_positively(int nodules, int found, int false_alarms) {
  return found == nodules && false_alarms == 0;
}

// Two searches in a row that were answered positively make the next one harder, one that was not makes it easier: it closes
// in on the level at which 71 of 100 are. By two levels up to the first time that it turns, by one from then on.
class DifficultyStaircase {
 public:
  explicit DifficultyStaircase(int start);
  int level() const;  // of the next search
  void answer(bool positive);

 private:
  experiment::Staircase staircase_;
};

}  // namespace palpate::applications::palpation
