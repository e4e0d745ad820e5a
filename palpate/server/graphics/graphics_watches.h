// What a running graphics server says when something begins or ends: the physics server gone and back, its
// clock set, a device in trouble. Each line once. One thread, the frame loop's.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "palpate/server/graphics/conditions.h"
#include "palpate/time/clock.h"
#include "palpate/time/clock_model.h"
#include "palpate/transport/state_link.h"

namespace palpate::server::graphics {

// Tells once that the physics server has gone, and once that it is back.
class ServerWatch {
 public:
  struct Change {
    Instant<GraphicsClock> time;
    bool there = false;
  };

  // `link` and `clock` outlive it.
  ServerWatch(const transport::StateLink& link, const Clock<GraphicsClock>& clock, std::string address);
  void look();
  bool there() const { return there_; }
  // The latest, should a server come and go for days.
  const std::deque<Change>& changes() const { return changes_; }
  std::string absence() const;

 private:
  const transport::StateLink& link_;
  const Clock<GraphicsClock>& clock_;
  std::string address_;
  bool there_ = true;
  std::deque<Change> changes_;
  std::optional<std::string> refusal_;
};

// Tells each time the physics server's clock was found stepped or stopped.
class ClockWatch {
 public:
  void look(const ClockSync<GraphicsClock, PhysicsClock>& sync);

 private:
  int restarts_ = 0;
};

// Tells each time a condition begins, finds other words, or ends.
class ConditionTeller {
 public:
  // Whether there was news.
  bool look(const std::vector<Condition>& now);
  // How often each has begun.
  const std::map<std::string, int>& begun() const { return begun_; }

 private:
  std::vector<Condition> told_;
  std::map<std::string, int> begun_;
};

}  // namespace palpate::server::graphics
