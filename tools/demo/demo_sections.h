// The parts of the demo's page, in the order in which they are told. Internal to this module.
#pragma once

#include "palpate/evaluation/report/report.h"
#include "palpate/figures/play_folder.h"

namespace palpate::tools::demo {

void add_what_you_see_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_arm_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_tip_and_camera_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_overlay_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_exchange_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_forces_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_play_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_touch_section(
    evaluation::report::Report& page,
    const figures::PlayFolder& data);  // instead of forces and play, where touch was played
inline bool touches(const figures::PlayFolder& data) { return data.find("touch") != nullptr; }
void add_real_time_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_network_section(evaluation::report::Report& page, const figures::PlayFolder& data);
void add_how_section(evaluation::report::Report& page, const figures::PlayFolder& data);

// In how many milliseconds the hand felt another force than was asked for, and why; nothing where it is not
// known. `made_up`: what is held off is paid back, as of impacts.
std::optional<figures::Figure> shaped_force(const figures::PlayFolder& data, bool made_up);

// Fewer serves than this say nothing about the player.
inline constexpr double kEnoughServes = 20.0;

// The bar of the arm's error: 0.3 mm and half of the best of the paper's methods, where those are known.
std::optional<double> arm_bar_mm(const figures::PlayFolder& data);

}  // namespace palpate::tools::demo
