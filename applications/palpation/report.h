// Palpation's part of a demo's page: what was pressed and felt, marks beside the truth. Its words are in report/. Pure.
#pragma once

#include "palpate/figures/page_file.h"
#include "palpate/figures/play_folder.h"
#include "palpate/scene/play_report.h"

namespace palpate::applications::palpation {

// data: presses (force_n, depth_mm over time_s, a gap where the tip had left), curves (force_n over depth_mm: above of
// presses within a nodule's radius of it, beside of the others), plan (x_mm, z_mm: pressed, nodules, found as the rims of
// those found, marks, false_marks). presses null where nothing was touched.
scene::PlayReport play_report(const figures::PlayFolder& play);

figures::PageFiles page_files();  // of report/

}  // namespace palpate::applications::palpation
