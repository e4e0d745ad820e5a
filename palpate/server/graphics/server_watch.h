// What a running graphics server tells the log of the physics server: that it has gone and is back, that it refuses, that
// its clock was set. Each line once. One thread, the frame loop's.
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "palpate/device/health_monitor.h"
#include "palpate/time/clock.h"
#include "palpate/time/clock_model.h"
#include "palpate/transport/state_link.h"

namespace palpate::server::graphics {

class ServerWatch {
 public:
  struct Change {
    Instant<GraphicsClock> time;
    bool there = false;
  };

  // `link` outlives it.
  ServerWatch(const transport::StateLink& link, std::string address)
      : link_(link), address_(std::move(address)) {}
  void look(const ClockSync<GraphicsClock, PhysicsClock>& sync, Instant<GraphicsClock> now);
  bool there() const { return health_.conditions().empty(); }
  // The latest, should a server come and go for days.
  const std::deque<Change>& changes() const { return changes_; }
  std::string absence() const;

 private:
  const transport::StateLink& link_;
  std::string address_;
  device::HealthMonitor<GraphicsClock> health_{Log("graphics")};
  std::deque<Change> changes_;
  std::optional<std::string> refusal_;
  int restarts_ = 0;
};

}  // namespace palpate::server::graphics
