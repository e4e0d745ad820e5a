// Ping-pong's part of a demo's page: what the hand felt of the hits, and how the game went. Its words and limits are in
// report/. Pure.
#pragma once

#include "palpate/figures/page_file.h"
#include "palpate/figures/play_folder.h"
#include "palpate/scene/play_report.h"

namespace palpate::applications::pingpong {

// data: ball (m, World, a gap where a serve begins), impacts (palpate/figures/impacts.h).
scene::PlayReport play_report(const figures::PlayFolder& play);

figures::PageFiles page_files();  // of report/

}  // namespace palpate::applications::pingpong
