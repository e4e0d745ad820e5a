// What happened while somebody looked on: outages and trips of the forces, conditions of devices as they begin and end.
//
// One thread. It is told of each status that comes, some times a second: what begins and ends between two of them is
// counted where the status counts it (outages), and else not seen.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>

#include "tools/console/lights.h"

namespace palpate::tools::console {

struct Event {
  std::uint64_t number = 0;  // 1, 2, ...
  double time_s = 0.0;       // of the physics server's life
  Level level = Level::notice;
  std::string words;
};

class EventLog {
 public:
  static constexpr std::size_t kMost = 200;  // the newest are kept

  void look(const SystemView& view);
  const std::deque<Event>& events() const { return events_; }

 private:
  void look_at_forces(const transport::ServerStatus& status);
  void look_at_conditions(const transport::ServerStatus& status);
  void add(double time_s, Level level, std::string words);

  std::deque<Event> events_;
  std::uint64_t count_ = 0, outages_ = 0;
  double uptime_s_ = -1.0;       // of the newest status; < 0: there was none
  std::optional<bool> answers_;  // none: there was no server yet
  device::ForceCondition forces_;
  std::map<std::pair<std::string, device::HealthCode>, std::string> conditions_;  // by client: its words
};

}  // namespace palpate::tools::console
