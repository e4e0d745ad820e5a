// What a page says of the forces that the hand felt: read from a play's folder, the same for every application. The
// arm's limit is the one that the play had (summary.json, force/limit_n). Pure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "palpate/figures/figure.h"
#include "palpate/figures/play_folder.h"
#include "palpate/figures/plot.h"

namespace palpate::figures {

// "8.5 N"; without it, words that say what it is.
std::string arm_limit(const PlayFolder& play);

// The strongest force, held against the arm's limit; nothing where it is not known.
std::optional<Figure> peak_force(const PlayFolder& play, std::string label);

// In how many milliseconds the hand felt another force than was asked for, and why; nothing where it is not
// known. `made_up`: what is held off is paid back, as of impacts.
std::optional<Figure> shaped_force(const PlayFolder& play, bool made_up);

// Of raw/haptics.csv: the strongest impact, millisecond by millisecond, and the peak of each over the play, which
// began at `begun_s`. Empty where there was none.
std::vector<Plot> impact_plots(const PlayFolder& play, double begun_s);

}  // namespace palpate::figures
