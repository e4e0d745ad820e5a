#include "palpate/sim/lockstep/play_figures.h"

#include <cmath>

#include "palpate/core/statistics.h"
#include "palpate/core/units.h"
#include "palpate/server/graphics/record_names.h"

namespace palpate::sim::lockstep {

Json exchange_figures(const LockstepResult& play) {
  Json answers = {{"exact", 0}, {"interpolated", 0}, {"extrapolated", 0}, {"too_old", 0}, {"too_new", 0}};
  int late = 0;
  for (const auto& frame : play.frames) {
    late += frame.record.late ? 1 : 0;
    auto& count = answers[server::graphics::answer_name(frame.record.answer)];
    count = count.get<int>() + 1;
  }
  ErrorSummary sync;
  for (double e : play.sync_errors_s) sync.add(std::abs(e) * 1e6);
  return {{"frames", play.frames.size()},
          {"late", late},
          {"answers", answers},
          {"lost", play.exchange.lost},
          {"sync_error_us_p99", sync.quantile(0.99)}};
}

Json force_figures(const haptics::HapticStatistics& haptic, double limit_n) {
  return {{"peak_n", haptic.peak_n},
          {"limit_n", limit_n},
          {"limited_ticks", haptic.limited_ticks},
          {"peak_limited_ticks", haptic.peak_limited_ticks},
          {"fault_ticks", haptic.fault_ticks},
          {"blows", haptic.impacts},
          {"rejected_blows", haptic.rejected_impacts},
          {"missed_blows", haptic.missed_impacts},
          {"lost_impulse_rel", haptic.lost_impulse_rel()},
          {"impulse_error_rel_max", haptic.impulse_error_rel_max}};
}

Json player_figures(const config::WorldFile& world) {
  const auto& player = world.player;
  return {{"reaction_ms", player.reaction_s * 1e3},
          {"aim_sd_mm", mm_from_metres(player.aim_sd)},
          {"max_hand_acceleration_m_s2", player.max_hand_acceleration},
          {"sees", "the drawn pictures' states only"}};
}

}  // namespace palpate::sim::lockstep
