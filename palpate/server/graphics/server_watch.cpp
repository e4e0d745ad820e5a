#include "palpate/server/graphics/server_watch.h"

#include <fmt/format.h>

#include <utility>

#include "palpate/core/text.h"

namespace palpate::server::graphics {
namespace {

constexpr Log kLog("graphics");
constexpr std::size_t kChangesKept = 1000;

}  // namespace

void ServerWatch::look(const ClockSync<GraphicsClock, PhysicsClock>& sync, Instant<GraphicsClock> now) {
  if (link_.refusal() != refusal_) {
    refusal_ = link_.refusal();
    if (refusal_)
      if (const auto more = refusals_told_.more(now))
        kLog.warning("the physics server at {} refuses: {}{}", address_, excerpt(*refusal_, 200), *more);
  }
  const bool was_there = there();
  if (link_.peer_alive() != was_there) {
    health_.set(was_there,
                {device::HealthCode::physics_server_gone, absence() + "; drawing goes on with the last state",
                 fmt::format("the physics server at {} answers again", address_)},
                now);
    changes_.push_back({now, !was_there});
    if (changes_.size() > kChangesKept) changes_.pop_front();
  }
  if (sync.restarts() == restarts_) return;
  restarts_ = sync.restarts();
  if (const auto more = restarts_told_.more(now))
    kLog.warning(
        "the physics server's clock was set, or stood still for a while; the clocks are synchronised anew{}",
        *more);
}

// What is to be added to the line; none: it is not to be said now.
std::optional<std::string> ServerWatch::Line::more(Instant<GraphicsClock> now) {
  if (said && now - *said < kSayAgain) {
    ++left_out;
    return std::nullopt;
  }
  said = now;
  const int count = std::exchange(left_out, 0);
  return count > 0 ? fmt::format(" (and {} since it was last said)",
                                 counted(static_cast<std::size_t>(count), "time"))
                   : std::string();
}

std::string ServerWatch::absence() const {
  return fmt::format("the physics server at {} no longer answers; start `palpate physics` again", address_);
}

}  // namespace palpate::server::graphics
