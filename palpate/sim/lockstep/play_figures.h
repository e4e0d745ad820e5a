// The figures of a play in lock-step that are the system's, whatever application was played: keys of a demo's summary.json
// and of `palpate lockstep --json`. Pure, any thread.
#pragma once

#include "palpate/core/json.h"
#include "palpate/sim/lockstep/lockstep_play.h"

namespace palpate::sim::lockstep {

// frames, late, answers {exact, interpolated, extrapolated, too_old, too_new}, lost, sync_error_us_p99
Json exchange_figures(const LockstepResult& play);
// peak_n, limit_n, limited_ticks, peak_limited_ticks, fault_ticks, blows, rejected_blows, missed_blows, lost_impulse_rel,
// impulse_error_rel_max
Json force_figures(const haptics::HapticStatistics& haptic, double limit_n);
// reaction_ms, aim_sd_mm, max_hand_acceleration_m_s2, sees
Json player_figures(const config::WorldFile& world);

}  // namespace palpate::sim::lockstep
