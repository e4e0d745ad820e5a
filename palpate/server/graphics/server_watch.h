// What a running graphics server tells the log of the physics server: that it has gone and is back, that it refuses, that
// its clock was set. Each line once, and no more often than kSayAgain, whatever a server says. One thread, the frame
// loop's.
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

  // Of refusals, and of clocks that were set.
  static constexpr Duration kSayAgain = std::chrono::seconds(10);

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
  // A line that may be said; how many were left out since the one before.
  struct Line {
    std::optional<Instant<GraphicsClock>> said;
    int left_out = 0;
    std::optional<std::string> more(Instant<GraphicsClock> now);
  };
  std::optional<std::string> refusal_;
  int restarts_ = 0;
  Line refusals_told_, restarts_told_;
};

}  // namespace palpate::server::graphics
