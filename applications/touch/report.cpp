#include "applications/touch/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "applications/touch/record.h"
#include "palpate/figures/force_figures.h"

namespace palpate::applications::touch {
namespace {

using figures::Figure, figures::PlayFolder, figures::Plot, figures::Section, figures::Series, figures::Tone,
    figures::Verdict;

constexpr double kLiftedOff_s = 0.005;  // without contact that long: another touch

// touch.csv, column by column.
struct Contact {
  std::vector<double> time, force, sideways, depth, sliding, x, z;  // s, N, N, mm, 0 or 1, m, m

  explicit Contact(const CsvTable& touch)
      : time(figures::column(touch, "time_s")),
        force(figures::column(touch, "force_n")),
        sideways(figures::column(touch, "tangential_n")),
        depth(figures::column(touch, "depth_mm")),
        sliding(figures::column(touch, "sliding")),
        x(figures::column(touch, "tip_x_m")),
        z(figures::column(touch, "tip_z_m")) {}
};

struct Span {
  double from, to, zero;  // s; the plot's time counts from `zero`
};

// A column over time, broken where the surface was left.
Series over_contacts(std::string name, Tone tone, const std::vector<double>& time,
                     const std::vector<double>& values, const Span& span) {
  Series series{.name = std::move(name), .tone = tone};
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] < span.from || time[i] > span.to) continue;
    if (i > 0 && time[i] - time[i - 1] > kLiftedOff_s) {
      series.x.push_back(NAN);
      series.y.push_back(NAN);
    }
    series.x.push_back(time[i] - span.zero);
    series.y.push_back(values[i]);
  }
  return series;
}

// The moment in which friction gave way after it had held longest.
double slip_to_show(const std::vector<double>& time, const std::vector<double>& sliding) {
  double best = time.front(), longest = 0.0, since = time.front();
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (time[i] - time[i - 1] > kLiftedOff_s || sliding[i - 1] > 0.5) since = time[i];
    if (sliding[i] > 0.5 && sliding[i - 1] < 0.5 && time[i] - since > longest) {
      longest = time[i] - since;
      best = time[i];
    }
  }
  return best;
}

std::vector<Plot> plots_of_all(const Contact& contact) {
  const Span all{contact.time.front(), contact.time.back(), contact.time.front()};
  Plot forces{.title = "Force while exploring",
              .x_label = "s since the first touch",
              .y_label = "N",
              .from_zero = true};
  forces.series = {over_contacts("whole", Tone::ours, contact.time, contact.force, all),
                   over_contacts("sideways", Tone::rival, contact.time, contact.sideways, all)};
  Plot depths{.title = "The tip beneath the surface",
              .x_label = "s since the first touch",
              .y_label = "mm",
              .from_zero = true};
  depths.series = {over_contacts("depth", Tone::ours, contact.time, contact.depth, all)};
  return {forces, depths};
}

Plot slip_plot(const Contact& contact) {
  const double slip = slip_to_show(contact.time, contact.sliding);
  const Span around{slip - 0.5, slip + 0.5, slip};
  std::vector<double> normal(contact.force.size());
  for (std::size_t i = 0; i < normal.size(); ++i)
    normal[i] = std::sqrt(
        std::max(0.0, contact.force[i] * contact.force[i] - contact.sideways[i] * contact.sideways[i]));
  Plot plot{.title = "Stick and slip: the second around the longest hold's end",
            .x_label = "s since friction gave way",
            .y_label = "N",
            .from_zero = true};
  plot.series = {over_contacts("sideways", Tone::rival, contact.time, contact.sideways, around),
                 over_contacts("along the normal", Tone::ours, contact.time, normal, around)};
  return plot;
}

Plot path_from_above(const Contact& contact) {
  constexpr std::size_t kEvery = 5;  // 5 ms: the hand moves less than a millimetre
  Plot plot{.title = "Where it was touched, from above",
            .x_label = "to the right, m",
            .y_label = "towards the wall \u2190 m \u2192 towards the user",
            .equal_axes = true};
  if (contact.x.empty() || contact.z.empty()) return plot;
  Series held{.name = "held", .mark = figures::Mark::points, .tone = Tone::rival},
      slid{.name = "slid", .mark = figures::Mark::points, .tone = Tone::ours};
  for (std::size_t i = 0; i < contact.x.size(); i += kEvery) {
    Series& series = contact.sliding[i] > 0.5 ? slid : held;
    series.x.push_back(contact.x[i]);
    series.y.push_back(contact.z[i]);
  }
  plot.series = {slid, held};
  plot.flip_y = true;
  return plot;
}

std::vector<Figure> figures_of(const PlayFolder& play) {
  std::vector<Figure> figures;
  const auto add = [&](std::string_view path, std::string label, std::string_view unit, std::string note) {
    if (const auto v = play.number(path))
      figures.push_back({std::move(label), figures::shown(v, unit), std::move(note), Verdict::none});
  };
  if (auto peak = figures::peak_force(play, "Strongest force given")) figures.push_back(std::move(*peak));
  add("touch/force_n/mean", "Force while touching, mean", "N", "asked for by the surface");
  add("touch/touches", "Times the surface was met", "", "");
  add("touch/contact_s", "Time in contact", "s",
      fmt::format("of {}", figures::shown(play.number("touch/of_s"), "s")));
  add("touch/depth_mm/mean", "Tip beneath the surface, mean", "mm", "force over stiffness");
  add("touch/depth_mm/max", "Tip beneath the surface, most", "mm", "");
  add("touch/slips", "Times friction gave way", "", "");
  add("touch/friction/median", "Sideways over normal force while sliding", "", "median");
  if (const auto v = play.number("touch/unsettled"))
    figures.push_back({"Milliseconds in which the sphere did not come to rest", fmt::format("{:.0f}", *v),
                       "it goes on in the next", Verdict::none});
  if (auto shaped = figures::shaped_force(play, false)) figures.push_back(std::move(*shaped));
  return figures;
}

Section touch_section(const PlayFolder& play) {
  Section section{"What the hand feels", "touch", {}};
  section.blocks.emplace_back(
      "The tip of the stylus goes beneath the surface, because a hand is softer than anything it touches; a "
      "sphere that cannot pass any triangle stays on top, and a spring between the two is what the hand "
      "feels. Friction holds the sphere until the pull sideways is too strong for it, then it slides with "
      "less. The scripted player knows only what the graphics server shows, learns it late, and presses and "
      "strokes so that all of this happens.");
  section.blocks.emplace_back(figures_of(play));
  const CsvTable* touch = play.raw(kTouchTable);
  if (touch == nullptr || !figures::has_columns(*touch, {"time_s", "force_n", "tangential_n", "depth_mm",
                                                         "speed_mm_s", "sliding"}))
    return section;
  const Contact contact(*touch);
  section.blocks.emplace_back(plots_of_all(contact));
  section.blocks.emplace_back(std::vector<Plot>{slip_plot(contact), path_from_above(contact)});
  return section;
}

}  // namespace

scene::PlayReport play_report(const PlayFolder& play) {
  scene::PlayReport report{
      .title = "Palpate: a surface you can see and feel",
      .task = "explore a surface",
      .scene =
          "The table is real; what lies on it exists only in the computer. The hand feels its surface "
          "through the stylus: how it is shaped, how far it gives way, how it holds and slips.",
      .drawn = "surface and stylus",
      .figures = {},
      .sections = {touch_section(play)}};
  if (const auto share = play.number("touch/contact_s"), of = play.number("touch/of_s"); share && of)
    report.figures.push_back({"On the surface", figures::shown(share, "s"),
                              fmt::format("of {}", figures::shown(of, "s")), Verdict::none});
  return report;
}

}  // namespace palpate::applications::touch
