// The demo report's part on touch: how the surface was explored, and what the hand felt of it.
#include <algorithm>
#include <cmath>

#include "tools/demo/demo_sections.h"

namespace palpate::tools::demo {
namespace {

constexpr double kArmLimit_N = 8.5;
constexpr double kLiftedOff_s = 0.005;  // without contact that long: another touch

// A column over time, broken where the surface was left.
figures::Series over_contacts(std::string name, figures::Tone tone, const std::vector<double>& time,
                              const std::vector<double>& values, double start, double from, double to) {
  figures::Series series{.name = std::move(name), .tone = tone};
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] < from || time[i] > to) continue;
    if (i > 0 && time[i] - time[i - 1] > kLiftedOff_s) {
      series.x.push_back(NAN);
      series.y.push_back(NAN);
    }
    series.x.push_back(time[i] - start);
    series.y.push_back(values[i]);
  }
  return series;
}

// The second around the moment in which friction gave way after it had held longest.
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

}  // namespace

void add_touch_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  page.section("What the hand feels", "touch");
  page.paragraph(
      "The tip of the stylus goes beneath the surface, because a hand is softer than anything it touches; a "
      "sphere "
      "that cannot pass any triangle stays on top, and a spring between the two is what the hand feels. "
      "Friction "
      "holds the sphere until the pull sideways is too strong for it, then it slides with less. The scripted "
      "player "
      "knows only what the graphics server shows, learns it late, and presses and strokes so that all of "
      "this "
      "happens.");
  std::vector<figures::Figure> figures;
  const auto add = [&](std::string_view path, std::string label, std::string_view unit, std::string note) {
    if (const auto v = data.number(path))
      figures.push_back({std::move(label), figures::shown(v, unit), std::move(note), figures::Verdict::none});
  };
  if (const auto peak = data.number("force/peak_n"))
    figures.push_back({"Strongest force given", figures::shown(peak, "N"), "at most 8.5 N, the arm's limit",
                       figures::at_most(*peak, kArmLimit_N)});
  add("touch/force_n/mean", "Force while touching, mean", "N", "asked for by the surface");
  add("touch/touches", "Times the surface was met", "", "");
  add("touch/contact_s", "Time in contact", "s",
      fmt::format("of {}", figures::shown(data.number("touch/of_s"), "s")));
  add("touch/depth_mm/mean", "Tip beneath the surface, mean", "mm", "force over stiffness");
  add("touch/depth_mm/max", "Tip beneath the surface, most", "mm", "");
  add("touch/slips", "Times friction gave way", "", "");
  add("touch/friction/median", "Sideways over normal force while sliding", "", "median");
  if (const auto v = data.number("touch/unsettled"))
    figures.push_back({"Milliseconds in which the sphere did not come to rest", fmt::format("{:.0f}", *v),
                       "it goes on in the next", figures::Verdict::none});
  if (auto shaped = shaped_force(data, false)) figures.push_back(std::move(*shaped));
  page.figures(figures);

  const CsvTable* touch = data.raw("touch.csv");
  if (touch == nullptr || !figures::has_columns(*touch, {"time_s", "force_n", "tangential_n", "depth_mm",
                                                         "speed_mm_s", "sliding"}))
    return;
  const auto time = figures::column(*touch, "time_s"), force = figures::column(*touch, "force_n"),
             sideways = figures::column(*touch, "tangential_n"), depth = figures::column(*touch, "depth_mm"),
             sliding = figures::column(*touch, "sliding");
  const double start = time.front(), end = time.back();
  figures::Plot forces{.title = "Force while exploring",
                       .x_label = "s since the first touch",
                       .y_label = "N",
                       .from_zero = true};
  forces.series = {over_contacts("whole", figures::Tone::ours, time, force, start, start, end),
                   over_contacts("sideways", figures::Tone::rival, time, sideways, start, start, end)};
  figures::Plot depths{.title = "The tip beneath the surface",
                       .x_label = "s since the first touch",
                       .y_label = "mm",
                       .from_zero = true};
  depths.series = {over_contacts("depth", figures::Tone::ours, time, depth, start, start, end)};
  page.plots({forces, depths});

  const double slip = slip_to_show(time, sliding);
  std::vector<double> normal(force.size());
  for (std::size_t i = 0; i < force.size(); ++i)
    normal[i] = std::sqrt(std::max(0.0, force[i] * force[i] - sideways[i] * sideways[i]));
  figures::Plot detail{.title = "Stick and slip: the second around the longest hold's end",
                       .x_label = "s since friction gave way",
                       .y_label = "N",
                       .from_zero = true};
  detail.series = {
      over_contacts("sideways", figures::Tone::rival, time, sideways, slip, slip - 0.5, slip + 0.5),
      over_contacts("along the normal", figures::Tone::ours, time, normal, slip, slip - 0.5, slip + 0.5)};
  figures::Plot path{.title = "Where it was touched, from above",
                     .x_label = "to the right, m",
                     .y_label = "towards the wall \u2190 m \u2192 towards the user",
                     .equal_axes = true};
  if (figures::has_columns(*touch, {"tip_x_m", "tip_z_m"})) {
    figures::Series held{.name = "held", .mark = figures::Mark::points, .tone = figures::Tone::rival},
        slid{.name = "slid", .mark = figures::Mark::points, .tone = figures::Tone::ours};
    const auto x = figures::column(*touch, "tip_x_m"), z = figures::column(*touch, "tip_z_m");
    constexpr std::size_t kEvery = 5;  // 5 ms: the hand moves less than a millimetre
    for (std::size_t i = 0; i < x.size(); i += kEvery) {
      figures::Series& series = sliding[i] > 0.5 ? slid : held;
      series.x.push_back(x[i]);
      series.y.push_back(z[i]);
    }
    path.series = {slid, held};
    path.flip_y = true;
  }
  page.plots({detail, path});
}

}  // namespace palpate::tools::demo
