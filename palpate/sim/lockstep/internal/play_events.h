// What happened in a play, as a list of moments: touches, what the bodies' paths jump at (blows, serves), what is wrong with a
// device. One thread.
#pragma once

#include <string>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/scene/application.h"
#include "palpate/server/graphics/frame_record.h"

namespace palpate::sim::lockstep {

class PlayEvents {
 public:
  explicit PlayEvents(const std::vector<scene::BodyDescription>& bodies) : bodies_(bodies) {}

  // Each state that counts, in order; times are counted from the first one.
  void add(const scene::SceneState& state);
  // The conditions that hold `time_s` after the first state.
  void add(double time_s, const std::vector<server::graphics::Condition>& conditions);

  // [{time_s, event, ...}] in the order of time; `event` is touch-begins, touch-ends, jump (with body),
  // condition-begins (with condition, words) or condition-ends (with condition).
  const Json& told() const { return told_; }

 private:
  void tell(double time_s, const char* event, Json more = Json::object());

  std::vector<scene::BodyDescription> bodies_;
  Json told_ = Json::array();
  bool begun_ = false;
  Instant<PhysicsClock> first_;
  scene::SceneState before_;
  std::vector<server::graphics::Condition> hold_;
};

}  // namespace palpate::sim::lockstep
