// The demo report's lock-step part: overlay, exchange, forces and play.
#include <algorithm>
#include <array>
#include <cmath>

#include "tools/demo/demo_sections.h"

namespace palpate::tools::demo {
namespace {

constexpr double kForceLimit = 8.5;  // N, of the simulated arm

struct Impact {
  std::size_t first = 0, last = 0;  // rows
  double peak_asked = 0.0, peak_given = 0.0;
};

// Contiguous runs of force, kept apart where 5 ms or more pass without any.
std::vector<Impact> impacts_in(const std::vector<double>& time, const std::vector<double>& asked,
                               const std::vector<double>& given) {
  std::vector<Impact> impacts;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (!(std::abs(asked[i]) > 1e-3)) continue;
    if (impacts.empty() || time[i] - time[impacts.back().last] > 0.005) impacts.push_back({i, i, 0.0, 0.0});
    Impact& impact = impacts.back();
    impact.last = i;
    impact.peak_asked = std::max(impact.peak_asked, std::abs(asked[i]));
    impact.peak_given = std::max(impact.peak_given, std::abs(given[i]));
  }
  return impacts;
}

// The player hits the ball within a few frames of flight; a jump farther than this between frames is a new
// serve.
constexpr double kServeJump = 0.35;  // m

figures::Plot ball_path(const CsvTable& ball, const char* horizontal, const char* vertical) {
  figures::Plot plot{.equal_axes = true};
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

// Outlines of the touched surfaces, as calibrated.
void outline(figures::Plot& plot, const figures::PlayFolder& data, std::string_view horizontal,
             std::string_view vertical) {
  const CsvTable* surface = data.raw("surface.csv");
  if (surface == nullptr || !figures::has_columns(*surface, {"label", "x_mm", "y_mm", "z_mm"})) return;
  const auto label = *surface->find("label");
  const auto h = figures::column(*surface, horizontal), v = figures::column(*surface, vertical);
  for (std::size_t i = 0; i + 3 < surface->rows.size(); i += 4) {
    // Touched several times over: once is enough to show it.
    if (std::any_of(plot.series.begin(), plot.series.end(),
                    [&](const figures::Series& s) { return s.name == surface->text[i][label]; }))
      continue;
    figures::Series side{.name = surface->text[i][label],
                         .tone = plot.series.size() % 2 == 1 ? figures::Tone::third : figures::Tone::fourth};
    for (std::size_t k : {0, 1, 2, 3, 0}) {
      side.x.push_back(h[i + k] / 1000.0);
      side.y.push_back(v[i + k] / 1000.0);
    }
    plot.series.push_back(side);
  }
}

}  // namespace

void add_overlay_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const auto world = data.number("registration/world_px_rms"), tip = data.number("registration/tip_px_rms");
  if (!world && !tip) return;
  page.section("The picture fits the world", "overlay");
  page.paragraph(
      "For every frame, points on table and wall that were not used for the registration are drawn where the "
      "system "
      "believes them to be, and compared with where the true camera sees them. The stylus tip is harder: its "
      "error also "
      "holds the arm's calibration and the moment in time for which the state was asked.");
  std::vector<figures::Figure> figures;
  if (world)
    figures.push_back(
        {"Real scene, rms", figures::shown(world, "px"), "at most 0.3 px", figures::at_most(*world, 0.3)});
  if (const auto p95 = data.number("registration/world_px_p95"))
    figures.push_back(
        {"Real scene, 95 % of points below", figures::shown(p95, "px"), "", figures::Verdict::none});
  if (const auto only = data.number("registration/world_px_rms_tracker_only")) {
    figures.push_back({"Real scene, by the tracker alone", figures::shown(only, "px"),
                       "without the landmarks in the picture", figures::Verdict::none});
  }
  if (const auto own = data.number("registration/own_estimate_px_rms")) {
    figures.push_back({"Real scene, as the system estimates it itself", figures::shown(own, "px"),
                       "knowing no truth: its mean over many calibrations like this one",
                       figures::Verdict::none});
  }
  if (tip)
    figures.push_back(
        {"Stylus tip, rms", figures::shown(tip, "px"), "at most 0.6 px", figures::at_most(*tip, 0.6)});
  if (const auto p95 = data.number("registration/tip_px_p95"))
    figures.push_back(
        {"Stylus tip, 95 % of frames below", figures::shown(p95, "px"), "", figures::Verdict::none});
  // The figures above are the left eye's where there are two.
  if (const auto right = data.number("registration/right_eye/world_px_rms"))
    figures.push_back({"Right eye, real scene, rms", figures::shown(right, "px"),
                       "at most 0.3 px; above is the left eye", figures::at_most(*right, 0.3)});
  if (const auto right_tip = data.number("registration/right_eye/tip_px_rms"))
    figures.push_back({"Right eye, stylus tip, rms", figures::shown(right_tip, "px"), "at most 0.6 px",
                       figures::at_most(*right_tip, 0.6)});
  if (const auto disparity = data.number("registration/disparity/ball_px_rms"))
    figures.push_back({"Virtual ball's disparity, beside a real one's", figures::shown(disparity, "px"),
                       "at most 0.3 px, or its depth is wrong", figures::at_most(*disparity, 0.3)});
  page.figures(figures);
  const CsvTable* frames = data.raw("frames.csv");
  if (frames == nullptr || !figures::has_columns(*frames, {"mid_exposure_s", "world_px", "tip_px"})) return;
  auto time = figures::column(*frames, "mid_exposure_s");
  const double start = *std::min_element(time.begin(), time.end());
  for (double& t : time) t -= start;
  const auto world_px = figures::column(*frames, "world_px"), tip_px = figures::column(*frames, "tip_px");
  figures::Plot over_time{
      .title = "Overlay error, frame by frame", .x_label = "s", .y_label = "px", .from_zero = true};
  over_time.series = {{.name = "stylus tip",
                       .x = time,
                       .y = tip_px,
                       .mark = figures::Mark::points,
                       .tone = figures::Tone::rival},
                      {.name = "real scene",
                       .x = time,
                       .y = world_px,
                       .mark = figures::Mark::points,
                       .tone = figures::Tone::ours}};
  if (figures::has_columns(*frames, {"expected_world_px"}))
    over_time.series.push_back({.name = "real scene, as the system estimates it itself",
                                .x = time,
                                .y = figures::column(*frames, "expected_world_px"),
                                .mark = figures::Mark::line,
                                .tone = figures::Tone::muted});
  const double most =
      std::max({figures::quantile(world_px, 0.995), figures::quantile(tip_px, 0.995), 0.1}) * 1.1;
  figures::Plot shares{.title = "Frames by overlay error", .x_label = "px", .y_label = "frames"};
  for (const auto& [name, values, tone] : {std::tuple{"stylus tip", &tip_px, figures::Tone::rival},
                                           {"real scene", &world_px, figures::Tone::ours}}) {
    figures::Series counts = figures::histogram(name, *values, 0.0, most, 60, tone);
    counts.mark = figures::Mark::area;
    shares.series.push_back(std::move(counts));
  }
  page.plots({over_time, shares});
}

void add_exchange_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const auto frames = data.number("exchange/frames");
  if (!frames) return;
  page.section("Two servers, one moment", "exchange");
  page.paragraph(
      "The graphics server asks the physics server for the state at the moment the picture was taken, goes "
      "on working, and "
      "uses the answer when the frame is done. It never waits: if an answer is late, the last known state is "
      "carried on. "
      "Each answer says how it was known.");
  std::vector<figures::Figure> figures{
      {"Frames", fmt::format("{:.0f}", *frames), "", figures::Verdict::none}};
  if (const auto late = data.number("exchange/late")) {
    figures.push_back({"Late answers", fmt::format("{:.0f}", *late),
                       fmt::format("{:.2f} % of the frames", *frames > 0 ? 100.0 * *late / *frames : 0.0),
                       figures::Verdict::none});
  }
  page.figures(figures);
  const std::array<std::pair<const char*, const char*>, 4> kinds{{
      {"exact", "exact: an entry of the history lies at that moment"},
      {"interpolated", "interpolated between two entries, a millisecond apart"},
      {"extrapolated", "extrapolated: carried ahead of the newest entry"},
      {"too_old", "too old: the history no longer reaches back"},
  }};
  std::vector<std::vector<std::string>> rows;
  for (const auto& [key, what] : kinds) {
    const auto count = data.number(fmt::format("exchange/answers/{}", key));
    if (!count) continue;
    rows.push_back({what, fmt::format("{:.0f}", *count),
                    fmt::format("{:.1f} %", *frames > 0 ? 100.0 * *count / *frames : 0.0)});
  }
  if (!rows.empty()) page.table({"How the answer was known", "frames", "share"}, rows);
}

std::optional<figures::Figure> shaped_force(const figures::PlayFolder& data, bool made_up) {
  const auto all = data.number("force/limited_ticks"), at_peak = data.number("force/peak_limited_ticks");
  if (!all) return std::nullopt;
  std::string why;
  if (*all == 0.0) {
    why = "neither the arm's limit nor that of its change was reached";
  } else if (at_peak) {
    const double others = *all - *at_peak;
    why = fmt::format("{} cut at the arm's limit", *at_peak > 0.0 ? fmt::format("{:.0f}", *at_peak) : "none");
    if (others > 0.0)
      why += fmt::format("; {} because a force can change by about 3\u00a0N a millisecond at most{}",
                         *at_peak > 0.0 ? fmt::format("{:.0f}", others) : "all",
                         made_up ? ", made up for right after" : "");
  }
  return figures::Figure{"Milliseconds in which the force was not as asked for", fmt::format("{:.0f}", *all),
                         std::move(why), figures::Verdict::none};
}

void add_forces_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const auto peak = data.number("force/peak_n");
  if (!peak) return;
  page.section("What the hand feels", "forces");
  page.paragraph(
      "A hit lasts about four milliseconds. The force follows a damped spring whose impulse equals the "
      "change of the ball's "
      "momentum, and is given to the arm at 1 kHz. The arm has two limits: 8.5 N, and a change of 3 N from "
      "one millisecond to the next, both of its own axes, along which a force can be a few percent larger. "
      "What they hold off is given a little later, so that the impulse stays whole; "
      "what even then cannot be given is counted, not hidden.");
  std::vector<figures::Figure> figures{{"Peak force", figures::shown(peak, "N"),
                                        "at most 8.5 N, the arm's limit",
                                        figures::at_most(*peak, kForceLimit)}};
  if (auto shaped = shaped_force(data, true)) figures.push_back(std::move(*shaped));
  if (const auto v = data.number("force/lost_impulse_rel"))
    figures.push_back({"Impulse lost to the limits", figures::shown(100.0 * *v, "%"),
                       "of all impulse asked for", figures::Verdict::none});
  if (const auto v = data.number("force/impulse_error_rel_max"))
    figures.push_back({"Impulse error, worst blow", fmt::format("{:.1e}", *v),
                       "at most 1e-9; relative, asked for against m (1 + e) v", figures::at_most(*v, 1e-9)});
  page.figures(figures);
  const CsvTable* haptics = data.raw("haptics.csv");
  if (haptics == nullptr || !figures::has_columns(*haptics, {"time_s", "asked_n", "given_n"})) return;
  const auto time = figures::column(*haptics, "time_s"), asked = figures::column(*haptics, "asked_n"),
             given = figures::column(*haptics, "given_n");
  const auto impacts = impacts_in(time, asked, given);
  if (impacts.empty()) return;
  const Impact& largest =
      *std::max_element(impacts.begin(), impacts.end(),
                        [](const Impact& a, const Impact& b) { return a.peak_given < b.peak_given; });
  figures::Plot detail{.title = "The strongest blow, millisecond by millisecond",
                       .x_label = "ms since the contact began",
                       .y_label = "N"};
  figures::Series wanted{
      .name = "asked for", .mark = figures::Mark::steps, .tone = figures::Tone::rival, .dashed = true};
  figures::Series felt{.name = "given", .mark = figures::Mark::steps, .tone = figures::Tone::ours};
  for (std::size_t i = 0; i < time.size(); ++i) {
    const double ms = 1000.0 * (time[i] - time[largest.first]);
    if (ms < -3.0 || ms > 1000.0 * (time[largest.last] - time[largest.first]) + 4.0) continue;
    wanted.x.push_back(ms);
    wanted.y.push_back(asked[i]);
    felt.x.push_back(ms);
    felt.y.push_back(given[i]);
  }
  detail.series = {felt, wanted};
  figures::Plot peaks{.title = "Every blow's peak", .x_label = "s since play began", .y_label = "N"};
  const CsvTable* ball = data.raw("ball.csv");
  const double begun = ball != nullptr && ball->has("time_s") && !ball->rows.empty()
                           ? figures::column(*ball, "time_s").front()
                           : 0.0;
  figures::Series points{.name = "given", .mark = figures::Mark::points, .tone = figures::Tone::ours};
  for (const Impact& impact : impacts) {
    points.x.push_back(time[impact.first] - begun);
    points.y.push_back(impact.peak_given);
  }
  peaks.series = {points};
  peaks.levels.push_back({.at = kForceLimit, .label = "limit of the arm", .tone = figures::Tone::bad});
  peaks.y_range = {0.0, 9.5};
  page.plots({detail, peaks});
}

void add_play_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const auto serves = data.number("rally/serves");
  if (!serves) return;
  page.section("The game", "game");
  page.paragraph(
      "The scripted player knows only what the graphics server shows, learns it 150 ms late, aims with noise "
      "and cannot "
      "accelerate the hand faster than a person. It plays so that the whole chain is tried, not to win.");
  page.paragraph(
      "Each serve comes off the wall. It counts as returned, once, when the bat has brought it back to the "
      "wall. "
      "If the "
      "player then meets the ball again and again, that is a rally: it counts every time the ball was "
      "brought to "
      "the wall since the serve, so a single serve can make a long one.");
  std::vector<figures::Figure> figures{
      {"Serves", fmt::format("{:.0f}", *serves), "", figures::Verdict::none}};
  if (const auto v = data.number("rally/returned"))
    figures.push_back(
        {"Serves returned to the wall", fmt::format("{:.0f}", *v),
         *serves < kEnoughServes ? "too few serves for a verdict" : "at least 60 %",
         *serves < kEnoughServes ? figures::Verdict::none : figures::at_least(*v, 0.6 * *serves)});
  if (const auto v = data.number("rally/longest"))
    figures.push_back({"Longest rally", fmt::format("{:.0f} {}", *v, *v == 1.0 ? "return" : "returns"),
                       "in a row after one serve", figures::Verdict::none});
  page.figures(figures);
  const CsvTable* ball = data.raw("ball.csv");
  if (ball == nullptr || !figures::has_columns(*ball, {"x_m", "y_m", "z_m"})) return;
  figures::Plot side = ball_path(*ball, "z_m", "y_m");
  side.title = "The ball from the side";
  side.x_label = "towards the player \u2190 m \u2192 towards the wall";
  side.y_label = "up, m";
  side.flip_x = true;
  outline(side, data, "z_mm", "y_mm");
  figures::Plot top = ball_path(*ball, "z_m", "x_m");
  top.title = "The ball from above";
  top.x_label = side.x_label;
  top.y_label = "to the player's right, m";
  top.flip_x = top.flip_y = true;
  outline(top, data, "z_mm", "x_mm");
  page.plots({side, top});
}

}  // namespace palpate::tools::demo
