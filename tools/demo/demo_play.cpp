// The demo report's lock-step part: overlay and exchange.
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/core/statistics.h"
#include "tools/demo/demo_sections.h"

namespace palpate::tools::demo {

namespace {

// registration/disparity has a key for the points of the real scene, and one for a virtual body, named after it.
void add_disparity(std::vector<figures::Figure>& figures, const figures::PlayFolder& data) {
  constexpr std::string_view kRms = "_px_rms";
  const Json* disparity = data.find("registration/disparity");
  if (disparity == nullptr || !disparity->is_object()) return;
  for (const auto& [key, value] : disparity->items()) {
    if (!key.ends_with(kRms) || key.starts_with("world") || !value.is_number()) continue;
    const auto px = value.get<double>();
    figures.push_back(
        {fmt::format("Virtual {}'s disparity, beside a real one's", key.substr(0, key.size() - kRms.size())),
         figures::shown(px, "px"), "at most 0.3 px, or its depth is wrong", figures::at_most(px, 0.3)});
  }
}

}  // namespace

void add_overlay_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const auto world = data.number("registration/world_px_rms"), tip = data.number("registration/tip_px_rms");
  if (!world && !tip) return;
  page.section("The picture fits the world", "overlay");
  page.paragraph(
      "For every frame, points on table and wall that were not used for the registration are drawn where the "
      "system believes them to be, and compared with where the true camera sees them. The stylus tip is "
      "harder: its error also holds the arm's calibration and the moment in time for which the state was "
      "asked.");
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
  add_disparity(figures, data);
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
  const double most = std::max({quantile(world_px, 0.995), quantile(tip_px, 0.995), 0.1}) * 1.1;
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
      "on working, and uses the answer when the frame is done. It never waits: if an answer is late, the "
      "last known state is carried on. Each answer says how it was known.");
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

}  // namespace palpate::tools::demo
