#include "tools/console/event_log.h"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/text.h"
#include "palpate/transport/messages.h"

namespace palpate::tools::console {
namespace {

Level level_of_fault(device::ForceFault fault) {
  return device::heals(fault) ? Level::warning : Level::fault;
}

}  // namespace

void EventLog::add(double time_s, Level level, std::string words) {
  events_.push_back({++count_, time_s, level, std::move(words)});
  if (events_.size() > kMost) events_.pop_front();
}

void EventLog::look(const SystemView& view) {
  if (!answers_ && view.server_answers) answers_ = true;
  if (answers_ && view.server_answers != *answers_) {
    answers_ = view.server_answers;
    add(std::max(uptime_s_, 0.0), *answers_ ? Level::good : Level::fault,
        *answers_ ? "the physics server answers again" : "the physics server no longer answers");
  }
  if (!view.server_answers || !view.status || view.status->uptime_s == uptime_s_) return;
  const auto& status = *view.status;
  if (status.uptime_s < uptime_s_) {  // another life
    add(status.uptime_s, Level::notice, "another physics server has taken the place of the one before");
    outages_ = 0;
    forces_ = {};
  }
  const bool first = uptime_s_ < 0.0;
  uptime_s_ = status.uptime_s;
  // What was before somebody looked is no news.
  if (first)
    for (const auto& loop : status.loops)
      if (loop.forces) outages_ = loop.trips;
  look_at_forces(status);
  look_at_conditions(status);
}

void EventLog::look_at_forces(const transport::ServerStatus& status) {
  for (const auto& loop : status.loops) {
    if (!loop.forces) continue;
    const auto outages = loop.trips - std::min(loop.trips, outages_);
    outages_ = loop.trips;
    const bool away = loop.forces->fault != device::ForceFault::none;
    if (away && loop.forces->fault != forces_.fault)
      add(status.uptime_s, level_of_fault(loop.forces->fault),
          "forces off: " + excerpt(loop.forces_text(), 150));
    else if (!away && forces_.fault != device::ForceFault::none)
      add(status.uptime_s, Level::good, "forces are back");
    else if (outages > 0)
      add(status.uptime_s, Level::notice, counted(outages, "outage") + " of the forces, over by now");
    forces_ = *loop.forces;
  }
}

void EventLog::look_at_conditions(const transport::ServerStatus& status) {
  auto before = std::move(conditions_);
  conditions_.clear();
  for (const auto& client : status.clients)
    for (const auto& condition : client.figures.conditions) {
      const auto key = std::pair(client.name, condition.code);
      conditions_[key] = condition.words;
      if (before.erase(key) > 0) continue;
      add(status.uptime_s, level_of(device::severity_of(condition.code)),
          fmt::format("{}: {}", excerpt(client.name, 64),
                      excerpt(condition.words, transport::kMaxConditionBytes)));
    }
  for (const auto& [key, words] : before)
    add(status.uptime_s, Level::good,
        fmt::format("{}: {}", excerpt(key.first, 64), device::end_of(key.second)));
}

}  // namespace palpate::tools::console
