// Every step of a physics loop, read from outside: for which times to ask a history of states, so that none of its steps
// stays unseen.
//
// A history answers for any time, and says whether the answer is a step's own state (exact) or lies between two; either has
// the tick of the last step until then. Questions a millisecond apart, from one step on, meet the steps of a loop of 1 kHz.
// Where the ticks of two answers tell of a step between them (one that began late), the time is narrowed down to it, to the
// nanosecond. A step that the history does not have shows as a gap in the ticks.
//
// Pure: whoever uses it carries questions and answers, in any order; what gets lost is asked again. One thread.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "palpate/scene/scene_state.h"

namespace palpate::scene {

class StepReader {
 public:
  using Time = Instant<PhysicsClock>;
  // Answers under way at once: half of what a server keeps for a client.
  static constexpr std::size_t kMostAsked = 32;
  static constexpr Duration kLostAfter = std::chrono::milliseconds(250);
  // No history goes so far: the answer is the newest step.
  static constexpr Time kFarAhead{std::chrono::hours(24 * 365 * 30)};

  // Looks for what is new once more; some hundred times a second.
  void look() { look_ = true; }
  // The next time to ask for; nothing, for now. `now`: of any clock, by which answers are missed.
  std::optional<Time> question(Duration now);
  // `asked`: the time of the question. Steps that this makes known, each once and in their order, are added to `steps`. The
  // first ever is the newest there is; so is the one with which it goes on where the history has passed it by.
  void answer(Time asked, const StateAnswer& answer, std::vector<SceneState>& steps);

 private:
  struct Floor {  // everything until then is known
    Time time;
    std::uint64_t tick = 0;
  };

  std::optional<Time> next(Duration now);
  bool asked_below(Time time) const;
  void begin(const SceneState& newest, std::vector<SceneState>& steps);
  void settle(std::vector<SceneState>& steps);
  void narrow(Time until);
  void deliver(const SceneState& step, std::vector<SceneState>& steps);

  bool look_ = true;
  std::optional<Floor> floor_;
  Time newest_, probe_;  // of the newest step known; of the last question on the grid
  std::map<Time, StateAnswer> answers_;
  std::map<Time, Duration> asked_;  // and when
  std::deque<Time> wanted_;         // to be asked before the grid goes on
  bool narrowed_ = false;           // the step to come is being narrowed down
  int off_grid_ = 0;                // steps in a row that were
};

}  // namespace palpate::scene
