// The impacts that the hand felt, read from a play's folder, the same for every application. Pure.
#pragma once

#include "palpate/core/json.h"
#include "palpate/figures/play_folder.h"

namespace palpate::figures {

// Of raw/haptics.csv, for a page: "strongest", the strongest impact millisecond by millisecond, with what was asked for
// and what was given ("ms", "asked_n", "given_n"); "peaks", the peak of each over the play ("time_s", "given_n"), which
// began with the state of the first picture of raw/frames.csv; "limit_n" and a range of N that shows it, where the arm's
// limit is known. Null where there was no impact.
Json impacts(const PlayFolder& play);

}  // namespace palpate::figures
