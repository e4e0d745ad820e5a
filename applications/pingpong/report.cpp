#include "applications/pingpong/report.h"

#include <fmt/format.h>

#include <cmath>

#include "applications/pingpong/record.h"
#include "palpate/figures/force_figures.h"
#include "palpate/figures/surface_outlines.h"

namespace palpate::applications::pingpong {
namespace {

using figures::Figure, figures::PlayFolder, figures::Plot, figures::Section, figures::Verdict;

// Fewer serves than this say nothing about the player.
constexpr double kEnoughServes = 20.0;
constexpr double kShareToReturn = 0.6;
// The player hits the ball within a few frames of flight; a jump farther than this between frames is a new
// serve.
constexpr double kServeJump = 0.35;  // m

Figure returned_figure(std::string label, std::string value, std::string too_few, double returned,
                       double serves) {
  const bool few = serves < kEnoughServes;
  return {std::move(label), std::move(value), few ? std::move(too_few) : "at least 60 %",
          few ? Verdict::none : figures::at_least(returned, kShareToReturn * serves)};
}

Section forces_section(const PlayFolder& play) {
  Section section{"What the hand feels", "forces", {}};
  section.blocks.emplace_back(fmt::format(
      "A hit lasts about four milliseconds. The force follows a damped spring whose impulse equals the "
      "change of the ball's momentum, and is given to the arm at 1 kHz. The arm has two limits: {}, and a "
      "change of 3 N from one millisecond to the next, both of its own axes, along which a force can be a "
      "few percent larger. What they hold off is given a little later, so that the impulse stays whole; what "
      "even then cannot be given is counted, not hidden.",
      figures::arm_limit(play)));
  std::vector<Figure> figures{*figures::peak_force(play, "Peak force")};
  if (auto shaped = figures::shaped_force(play, true)) figures.push_back(std::move(*shaped));
  if (const auto v = play.number("force/lost_impulse_rel"))
    figures.push_back({"Impulse lost to the limits", figures::shown(100.0 * *v, "%"),
                       "of all impulse asked for", Verdict::none});
  if (const auto v = play.number("force/impulse_error_rel_max"))
    figures.push_back({"Impulse error, worst blow", fmt::format("{:.1e}", *v),
                       "at most 1e-9; relative, asked for against m (1 + e) v", figures::at_most(*v, 1e-9)});
  section.blocks.emplace_back(std::move(figures));
  const CsvTable* ball = play.raw(kBallTable);
  const double begun =
      ball != nullptr && ball->has("time_s") ? figures::column(*ball, "time_s").front() : 0.0;
  if (auto plots = figures::impact_plots(play, begun); !plots.empty())
    section.blocks.emplace_back(std::move(plots));
  return section;
}

Plot ball_path(const CsvTable& ball, const char* horizontal, const char* vertical) {
  Plot plot{.equal_axes = true};
  figures::Series path{.name = "ball", .tone = figures::Tone::ours};
  const auto x = figures::column(ball, "x_m"), y = figures::column(ball, "y_m"),
             z = figures::column(ball, "z_m");
  const auto h = figures::column(ball, horizontal), v = figures::column(ball, vertical);
  for (std::size_t i = 0; i < h.size(); ++i) {
    const bool jump = i > 0 && std::hypot(x[i] - x[i - 1], y[i] - y[i - 1], z[i] - z[i - 1]) > kServeJump;
    if (jump) {
      path.x.push_back(NAN);
      path.y.push_back(NAN);
    }
    path.x.push_back(h[i]);
    path.y.push_back(v[i]);
  }
  plot.series.push_back(path);
  return plot;
}

std::vector<Plot> paths_of_the_ball(const PlayFolder& play) {
  const CsvTable* ball = play.raw(kBallTable);
  if (ball == nullptr || !figures::has_columns(*ball, {"x_m", "y_m", "z_m"})) return {};
  Plot side = ball_path(*ball, "z_m", "y_m");
  side.title = "The ball from the side";
  side.x_label = "towards the player \u2190 m \u2192 towards the wall";
  side.y_label = "up, m";
  side.flip_x = true;
  figures::add_surface_outlines(side, play, "z_mm", "y_mm");
  Plot top = ball_path(*ball, "z_m", "x_m");
  top.title = "The ball from above";
  top.x_label = side.x_label;
  top.y_label = "to the player's right, m";
  top.flip_x = top.flip_y = true;
  figures::add_surface_outlines(top, play, "z_mm", "x_mm");
  return {side, top};
}

Section game_section(const PlayFolder& play, double serves) {
  Section section{"The game", "game", {}};
  section.blocks.emplace_back(
      "The scripted player knows only what the graphics server shows, learns it 150 ms late, aims with noise "
      "and cannot accelerate the hand faster than a person. It plays so that the whole chain is tried, not "
      "to win.");
  section.blocks.emplace_back(
      "Each serve comes off the wall. It counts as returned, once, when the bat has brought it back to the "
      "wall. If the player then meets the ball again and again, that is a rally: it counts every time the "
      "ball was brought to the wall since the serve, so a single serve can make a long one.");
  std::vector<Figure> figures{{"Serves", fmt::format("{:.0f}", serves), "", Verdict::none}};
  if (const auto v = play.number("rally/returned"))
    figures.push_back(returned_figure("Serves returned to the wall", fmt::format("{:.0f}", *v),
                                      "too few serves for a verdict", *v, serves));
  if (const auto v = play.number("rally/longest"))
    figures.push_back({"Longest rally", fmt::format("{:.0f} {}", *v, *v == 1.0 ? "return" : "returns"),
                       "in a row after one serve", Verdict::none});
  section.blocks.emplace_back(std::move(figures));
  if (auto plots = paths_of_the_ball(play); !plots.empty()) section.blocks.emplace_back(std::move(plots));
  return section;
}

}  // namespace

scene::PlayReport play_report(const PlayFolder& play) {
  scene::PlayReport report{
      .title = "Palpate: ping-pong you can see and feel",
      .task = "play ping-pong",
      .scene =
          "Table and wall are real; ball and bat exist only in the computer. The bat rides on the "
          "stylus, the ball bounces off the real table and the real wall, and each hit is felt in the "
          "hand.",
      .drawn = "ball and bat",
      .force_label = "Strongest blow the hand felt",
      .figures = {},
      .sections = {}};
  const auto serves = play.number("rally/serves"), returned = play.number("rally/returned");
  if (serves && returned && *serves > 0)
    report.figures.push_back(returned_figure("Serves returned",
                                             fmt::format("{:.0f} of {:.0f}", *returned, *serves),
                                             "too few for a verdict", *returned, *serves));
  if (play.number("force/peak_n")) report.sections.push_back(forces_section(play));
  if (serves) report.sections.push_back(game_section(play, *serves));
  return report;
}

}  // namespace palpate::applications::pingpong
