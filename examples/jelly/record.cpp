#include "record.h"

#include <fmt/format.h>

#include <algorithm>

#include "application.h"
#include "palpate/core/csv.h"
#include "palpate/core/units.h"

namespace jelly {

using palpate::scene::Highlight;

void JellyRecord::add_state(const palpate::scene::SceneState& state) {
  const double force = 1e-3 * state.counters[kForceMn], dent = 1e-6 * state.counters[kDentUm];
  presses_ = state.counters[kPresses];
  peak_ = std::max(peak_, force);
  deepest_ = std::max(deepest_, dent);
  rows_.push_back({state.time.seconds(), force, dent});
}

Highlight JellyRecord::highlight(const palpate::scene::ShownPicture& picture) const {
  const auto& state = picture.state;
  const std::string what =
      state.counters[kForceMn] > 0 ? "the tip presses into the jelly" : "the jelly at rest";
  return {.in_sight = picture.have_state && state.body_count > kTip && picture.shows(state.bodies[kTip].p()),
          .events = state.counters[kPresses],
          .event = "press",
          .just_after = "the tip has just met the jelly",
          .going_on = what,
          .unseen = what + ", out of the picture"};
}

std::vector<std::string> JellyRecord::tables() const {
  palpate::CsvWriter csv({"time_s", "force_n", "dent_mm"});
  for (const Row& row : rows_)
    csv.row(std::vector<double>{row.time, row.force, palpate::mm_from_metres(row.dent)});
  return {csv.content()};
}

palpate::Json JellyRecord::summary() const {
  return {{"jelly",
           {{"presses", presses_},
            {"peak_force_n", peak_},
            {"deepest_dent_mm", palpate::mm_from_metres(deepest_)}}}};
}

std::vector<palpate::scene::ClosingLine> JellyRecord::closing_lines(const palpate::Json& summary) const {
  const auto& jelly = summary["jelly"];
  return {{"jelly",
           fmt::format("{} presses, {:.1f} mm deep at most, peak force {:.1f} N", jelly["presses"].get<int>(),
                       jelly["deepest_dent_mm"].get<double>(), jelly["peak_force_n"].get<double>())}};
}

palpate::scene::PlayReport report_of(const palpate::figures::PlayFolder& play) {
  namespace figures = palpate::figures;
  figures::Section section{"What the hand feels", "jelly", {}};
  section.blocks.emplace_back(
      "The tip meets the surface as it is in that millisecond: a spring between the two is what the hand "
      "feels, and what dents the jelly. Let go, it wobbles.");
  if (const auto* table = play.raw(kTable);
      table != nullptr && figures::has_columns(*table, {"time_s", "force_n", "dent_mm"})) {
    const auto time = figures::column(*table, "time_s");
    std::vector<figures::Plot> plots;
    for (const auto& [column, title, unit] : {std::array{"force_n", "Force on the hand", "N"},
                                              std::array{"dent_mm", "The deepest place of the dent", "mm"}}) {
      figures::Plot plot{.title = title, .x_label = "s", .y_label = unit, .from_zero = true};
      plot.series.push_back({.name = title, .x = time, .y = figures::column(*table, column)});
      plots.push_back(plot);
    }
    section.blocks.emplace_back(plots);
  }
  return {
      .title = "Palpate: a jelly you can see and feel",
      .task = "prod a jelly",
      .scene =
          "The table is real; the jelly on it exists only in the computer. The hand feels how it gives way.",
      .drawn = "jelly and stylus",
      .figures = {},
      .sections = {section}};
}

}  // namespace jelly
