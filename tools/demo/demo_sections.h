// The parts of the demo's page, in the order in which they are told. Internal to this module.
#pragma once

#include "palpate/evaluation/report/report.h"
#include "palpate/figures/play_folder.h"
#include "palpate/scene/play_record.h"
#include "palpate/scene/play_report.h"

namespace palpate::tools::demo {

void add_what_you_see_section(evaluation::report::Report& page, const figures::PlayFolder& data,
                              const scene::PlayReport& play);
void add_arm_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_tip_and_camera_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_overlay_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_exchange_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_real_time_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_network_section(evaluation::report::Report& page, const figures::PlayFolder& data);
// `tables`: the application's among the files.
void add_how_section(evaluation::report::Report& page, const figures::PlayFolder& data,
                     const std::vector<scene::PlayTable>& tables);

// The bar of the arm's error: 0.3 mm and half of the best of the paper's methods, where those are known.
std::optional<double> arm_bar_mm(const figures::PlayFolder& data);

}  // namespace palpate::tools::demo
