// The part of a demo's page that tells of a touched surface: how it was explored, and what the hand felt of it. Pure.
#pragma once

#include "palpate/figures/play_folder.h"
#include "palpate/scene/play_report.h"

namespace palpate::applications::touch {

// From force, touch and raw/touch.csv, each of them where it is there.
scene::PlayReport play_report(const figures::PlayFolder& play);

}  // namespace palpate::applications::touch
