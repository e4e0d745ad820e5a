// Where a person is led through a whole session: a terminal, a window; beside what is asked for (guided_person.h) the
// steps, their results and what is known so far.
//
// Called by the session's thread alone.
#pragma once

#include <string>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/guided_person.h"
#include "palpate/calibration/session/guided_poses.h"
#include "palpate/rig/rig.h"

namespace palpate::calibration::session {

class SessionPanel : public Panel {
 public:
  // `step`: from 0.
  virtual void begin_step(std::size_t step, std::size_t steps, const std::string& name) = 0;
  // The step that has begun is over: the rig has its result from before.
  virtual void keep_step(const std::string& name, const std::string& words) = 0;
  // Shows a step's result and waits for the answer.
  virtual Review review(const StepOutcome& outcome) = 0;
  // After each guided pose, of so many.
  virtual void guided(const GuidanceState& state, int of) = 0;
  // What the rig has by now, for those who draw with it.
  virtual void show_rig(const rig::Rig& rig) { static_cast<void>(rig); }
};

}  // namespace palpate::calibration::session
