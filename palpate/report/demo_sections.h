// The parts of the demo's page, in the order in which they are told. Internal to this module.
#pragma once

#include "palpate/report/demo_data.h"
#include "palpate/report/report.h"

namespace palpate::report {

void tell_what_you_see(Report& page, const DemoData& data);
void tell_arm(Report& page, const DemoData& data);
void tell_tip_and_camera(Report& page, const DemoData& data);
void tell_overlay(Report& page, const DemoData& data);
void tell_exchange(Report& page, const DemoData& data);
void tell_forces(Report& page, const DemoData& data);
void tell_play(Report& page, const DemoData& data);
void tell_touch(Report& page, const DemoData& data);  // instead of forces and play, where touch was played
inline bool touches(const DemoData& data) { return data.find("touch") != nullptr; }
void tell_real_time(Report& page, const DemoData& data);
void tell_network(Report& page, const DemoData& data);
void tell_how(Report& page, const DemoData& data);

// In how many milliseconds the hand felt another force than was asked for, and why; nothing where it is not
// known. `made_up`: what is held off is paid back, as of blows.
std::optional<Figure> shaped_force(const DemoData& data, bool made_up);

// Fewer serves than this say nothing about the player.
inline constexpr double kEnoughServes = 20.0;

// The bar of the arm's error: 0.3 mm and half of the best of the paper's methods, where those are known.
std::optional<double> arm_bar_mm(const DemoData& data);

}  // namespace palpate::report
