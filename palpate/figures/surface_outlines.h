// The real surfaces of a play as lines in a plot. Pure.
#pragma once

#include <string_view>

#include "palpate/figures/play_folder.h"
#include "palpate/figures/plot.h"

namespace palpate::figures {

// Adds to a plot in metres the outline of each surface of raw/surface.csv (corners in touching order, mm, World).
// `horizontal`, `vertical`: the columns that the plot's axes are.
void add_surface_outlines(Plot& plot, const PlayFolder& play, std::string_view horizontal,
                          std::string_view vertical);

}  // namespace palpate::figures
