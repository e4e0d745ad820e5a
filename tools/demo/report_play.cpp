// Of the demo's page: what the play in lock-step has to draw.
#include <algorithm>

#include "palpate/core/statistics.h"
#include "palpate/figures/plot.h"
#include "tools/demo/report_data.h"

namespace palpate::tools::demo {
namespace {

using figures::PlayFolder, figures::column, figures::has_columns;

// Each surface of raw/surface.csv once, as a closed line, m, World.
Json surfaces(const CsvTable& surface) {
  if (!has_columns(surface, {"label", "x_mm", "y_mm", "z_mm"})) return nullptr;
  const auto label = *surface.find("label");
  Json list = Json::array();
  for (std::size_t i = 0; i + 3 < surface.rows.size(); i += 4) {
    const std::string& name = surface.text[i][label];
    // Touched several times over: once is enough to show it.
    if (std::any_of(list.begin(), list.end(), [&](const Json& one) { return one["label"] == name; }))
      continue;
    Json outline{{"label", name}, {"even", list.size() % 2 == 1}};
    for (const auto& axis : {"x", "y", "z"}) {
      const auto mm = column(surface, fmt::format("{}_mm", axis));
      std::vector<double> m;
      for (std::size_t k : {0, 1, 2, 3, 0}) m.push_back(mm[i + k] / 1000.0);
      outline[fmt::format("{}_m", axis)] = m;
    }
    list.push_back(outline);
  }
  return list;
}

void add_overlay(Json& data, const CsvTable& frames) {
  if (!has_columns(frames, {"mid_exposure_s", "world_px", "tip_px"})) return;
  auto time = column(frames, "mid_exposure_s");
  const double start = *std::min_element(time.begin(), time.end());
  for (double& t : time) t -= start;
  const auto world = column(frames, "world_px"), tip = column(frames, "tip_px");
  data["overlay"] = {{"time_s", time},
                     {"world_px", world},
                     {"tip_px", tip},
                     {"has_expected", frames.has("expected_world_px")},
                     {"expected_px", column(frames, "expected_world_px")}};
  const double most = std::max({quantile(world, 0.995), quantile(tip, 0.995), 0.1}) * 1.1;
  data["overlay_shares"] = {{"world", xy(figures::histogram("", world, 0.0, most, 60))},
                            {"tip", xy(figures::histogram("", tip, 0.0, most, 60))}};
}

}  // namespace

Json play_data(const PlayFolder& play) {
  Json data = Json::object();
  if (const CsvTable* frames = play.raw("frames.csv")) add_overlay(data, *frames);
  if (const CsvTable* surface = play.raw("surface.csv"))
    if (Json list = surfaces(*surface); !list.is_null()) data["surfaces"] = std::move(list);
  if (const auto frames = play.number("exchange/frames")) {
    const auto counted = [&](const char* path) -> Json {
      const auto count = play.number(path);
      if (!count) return nullptr;
      return {{"count", *count}, {"share", *frames > 0 ? *count / *frames : 0.0}};
    };
    data["late"] = counted("exchange/late");
    for (const char* kind : {"exact", "interpolated", "extrapolated", "too_old"})
      if (Json part = counted(fmt::format("exchange/answers/{}", kind).c_str()); !part.is_null())
        data["answers"][kind] = std::move(part);
  }
  return data;
}

}  // namespace palpate::tools::demo
