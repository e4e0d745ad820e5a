// The touched surface's part of a demo's page: what the hand felt while it explored. Its words are in report/. Pure.
#pragma once

#include "palpate/figures/page_file.h"
#include "palpate/figures/play_folder.h"
#include "palpate/scene/play_report.h"

namespace palpate::applications::touch {

// data: contact (force_n, sideways_n, depth_mm over time_s, a gap where the tip had left the surface), slip (the second
// around the end of the longest hold), path (where the tip held and slid, m, World). contact null where it was not touched.
scene::PlayReport play_report(const figures::PlayFolder& play);

figures::PageFiles page_files();  // of report/

}  // namespace palpate::applications::touch
