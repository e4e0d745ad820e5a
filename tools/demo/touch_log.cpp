#include "tools/demo/touch_log.h"

#include "applications/touch/touch.h"
#include "palpate/core/csv.h"
#include "palpate/core/error_summary.h"
#include "palpate/core/file.h"
#include "palpate/core/units.h"

namespace palpate::tools::demo {

void TouchLog::add(const scene::SceneState& state) {
  const double t = state.time.seconds();
  if (all_ == 0) first_ = t;
  last_ = t;
  ++all_;
  touches_ = state.counters[applications::touch::kTouches];
  slips_ = state.counters[applications::touch::kSlips];
  unsettled_ = state.counters[applications::touch::kUnsettled];
  if (state.continuous.touching == 0) return;
  const auto& stylus = state.bodies[applications::touch::kStylus];
  const auto& proxy = state.bodies[applications::touch::kProxy];
  const Vector3 force(state.continuous.force.data()), point(state.continuous.point.data());
  const Vector3 out = proxy.p() - point;
  const Vector3 normal = out.norm() > 0.0 ? Vector3(out.normalized()) : Vector3(Vector3::UnitY());
  rows_.push_back({t, force.norm(), (force - force.dot(normal) * normal).norm(),
                   1e-6 * state.counters[applications::touch::kDepthUm], stylus.v().norm(),
                   state.counters[applications::touch::kSliding] != 0, stylus.p(), normal});
}

Json TouchLog::summary() const {
  ErrorSummary force, depth, friction;
  std::size_t sliding = 0;
  for (const Row& row : rows_) {
    force.add(row.force);
    depth.add(mm_from_metres(row.depth));
    sliding += row.sliding;
    const double normal = std::sqrt(std::max(0.0, row.force * row.force - row.tangential * row.tangential));
    constexpr double kFirmly_N = 0.2;  // less, and the ratio is made of little
    if (row.sliding && normal > kFirmly_N) friction.add(row.tangential / normal);
  }
  const auto spread = [](const ErrorSummary& values) -> Json {
    if (values.empty()) return Json::object();
    return {{"mean", values.mean()}, {"p95", values.quantile(0.95)}, {"max", values.quantile(1.0)}};
  };
  const auto ticks = static_cast<double>(rows_.size());
  const double tick_s = all_ > 1 ? (last_ - first_) / static_cast<double>(all_ - 1) : 0.0;
  Json json = {{"contact_s", tick_s * ticks},
               {"of_s", last_ - first_},
               {"touches", touches_},
               {"slips", slips_},
               {"sliding_share", ticks > 0.0 ? static_cast<double>(sliding) / ticks : 0.0},
               {"force_n", spread(force)},
               {"depth_mm", spread(depth)},
               {"unsettled", unsettled_}};
  if (!friction.empty()) json["friction"] = {{"median", friction.quantile(0.5)}};
  return json;
}

Expected<void> TouchLog::write(const std::filesystem::path& folder) const {
  CsvWriter csv({"time_s", "force_n", "tangential_n", "depth_mm", "speed_mm_s", "sliding", "tip_x_m",
                 "tip_y_m", "tip_z_m", "normal_x", "normal_y", "normal_z"});
  for (const Row& row : rows_)
    csv.row(std::vector<double>{row.time, row.force, row.tangential, mm_from_metres(row.depth),
                                mm_from_metres(row.speed), row.sliding ? 1.0 : 0.0, row.tip.x(), row.tip.y(),
                                row.tip.z(), row.normal.x(), row.normal.y(), row.normal.z()});
  return write_file(folder / "touch.csv", csv.content());
}

}  // namespace palpate::tools::demo
