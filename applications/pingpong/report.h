// Ping-pong's part of a demo's page: what the hand felt of the hits, and how the game went. Pure.
#pragma once

#include "palpate/figures/play_folder.h"
#include "palpate/scene/play_report.h"

namespace palpate::applications::pingpong {

// From force, rally, raw/haptics.csv, raw/ball.csv and the outlines in raw/surface.csv, each of them where it is
// there.
scene::PlayReport play_report(const figures::PlayFolder& play);

}  // namespace palpate::applications::pingpong
