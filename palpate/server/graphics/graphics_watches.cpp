#include "palpate/server/graphics/graphics_watches.h"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/log.h"
#include "palpate/core/text.h"

namespace palpate::server::graphics {
namespace {

constexpr Log kLog("graphics");
constexpr std::size_t kChangesKept = 1000;

const Condition* among(const std::vector<Condition>& conditions, ConditionKind kind) {
  const auto at =
      std::find_if(conditions.begin(), conditions.end(), [kind](const auto& c) { return c.kind == kind; });
  return at == conditions.end() ? nullptr : &*at;
}

}  // namespace

ServerWatch::ServerWatch(const transport::StateLink& link, const Clock<GraphicsClock>& clock,
                         std::string address)
    : link_(link), clock_(clock), address_(std::move(address)) {}

void ServerWatch::look() {
  if (link_.refusal() != refusal_) {
    refusal_ = link_.refusal();
    if (refusal_) kLog.warning("the physics server at {} refuses: {}", address_, excerpt(*refusal_, 200));
  }
  if (link_.peer_alive() == there_) return;
  there_ = !there_;
  changes_.push_back({clock_.now(), there_});
  if (changes_.size() > kChangesKept) changes_.pop_front();
  if (there_)
    kLog.info("the physics server at {} answers again", address_);
  else
    kLog.warning("{}; drawing goes on with the last state", absence());
}

std::string ServerWatch::absence() const {
  return fmt::format("the physics server at {} no longer answers; start `palpate physics` again", address_);
}

void ClockWatch::look(const ClockSync<GraphicsClock, PhysicsClock>& sync) {
  if (sync.restarts() == restarts_) return;
  restarts_ = sync.restarts();
  kLog.info(
      "the physics server's clock was set, or stood still for a while; the clocks are "
      "synchronised anew");
}

bool ConditionTeller::look(const std::vector<Condition>& now) {
  bool news = now.size() != told_.size();
  for (const auto& condition : now) {
    const Condition* before = among(told_, condition.kind);
    news = news || before == nullptr || before->text != condition.text;
    if (before == nullptr) ++begun_[name_of(condition.kind)];
    if (before == nullptr || before->text != condition.text) kLog.write(LogLevel::warning, condition.text);
  }
  for (const auto& condition : told_)
    if (among(now, condition.kind) == nullptr) kLog.write(LogLevel::info, end_of(condition.kind));
  told_ = now;
  return news;
}

}  // namespace palpate::server::graphics
