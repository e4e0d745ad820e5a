#include "palpate/sim/lockstep/internal/play_events.h"

#include <fmt/format.h>

#include <algorithm>

namespace palpate::sim::lockstep {
namespace {

bool among(const std::vector<server::graphics::Condition>& conditions, device::HealthCode code) {
  return std::any_of(conditions.begin(), conditions.end(),
                     [code](const auto& one) { return one.code == code; });
}

}  // namespace

void PlayEvents::tell(double time_s, const char* event, Json more) {
  Json told = {{"time_s", time_s}, {"event", event}};
  told.update(more);
  told_.push_back(std::move(told));
}

void PlayEvents::add(const scene::SceneState& state) {
  if (!begun_) {
    begun_ = true;
    first_ = state.time;
    before_ = state;
    before_.continuous.touching = 0;
  }
  const double time_s = to_seconds(state.time - first_);
  if (state.continuous.touching != before_.continuous.touching)
    tell(time_s, state.continuous.touching != 0 ? "touch-begins" : "touch-ends");
  const int bodies = std::min(state.body_count, before_.body_count);
  for (int i = 0; i < bodies; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (state.bodies[at].jumps == before_.bodies[at].jumps) continue;
    const std::string name = at < bodies_.size() ? bodies_[at].name : "";
    tell(time_s, "jump", {{"body", name.empty() ? fmt::format("{}", i) : name}});
  }
  before_ = state;
}

void PlayEvents::add(double time_s, const std::vector<server::graphics::Condition>& conditions) {
  for (const auto& one : conditions)
    if (!among(hold_, one.code))
      tell(time_s, "condition-begins", {{"condition", device::name_of(one.code)}, {"words", one.words}});
  for (const auto& one : hold_)
    if (!among(conditions, one.code))
      tell(time_s, "condition-ends", {{"condition", device::name_of(one.code)}});
  hold_ = conditions;
}

}  // namespace palpate::sim::lockstep
