#include "applications/touch/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "applications/touch/report.h"
#include "applications/touch/touch.h"
#include "palpate/core/csv.h"
#include "palpate/core/statistics.h"
#include "palpate/core/units.h"

namespace palpate::applications::touch {

void TouchRecord::add_state(const scene::SceneState& state) {
  const double t = state.time.seconds();
  if (all_ == 0) first_ = t;
  last_ = t;
  ++all_;
  touches_ = state.counters[kTouches];
  slips_ = state.counters[kSlips];
  unsettled_ = state.counters[kUnsettled];
  if (state.continuous.touching == 0) return;
  const auto& stylus = state.bodies[kStylus];
  const auto& proxy = state.bodies[kProxy];
  const Vector3 force(state.continuous.force.data()), point(state.continuous.point.data());
  const Vector3 out = proxy.p() - point;
  const Vector3 normal = out.norm() > 0.0 ? Vector3(out.normalized()) : Vector3(Vector3::UnitY());
  rows_.push_back({t, force.norm(), (force - force.dot(normal) * normal).norm(),
                   1e-6 * state.counters[kDepthUm], stylus.v().norm(), state.counters[kSliding] != 0,
                   stylus.p(), normal});
}

scene::Highlight TouchRecord::highlight(const scene::ShownPicture& picture) const {
  const auto& state = picture.state;
  const std::string tip = state.counters[kForceMn] <= 0  ? "the tip above the surface"
                          : state.counters[kSliding] > 0 ? "the tip slides over the surface"
                                                         : "the tip holds on the surface";
  return {
      .in_sight = picture.have_state && state.body_count > kProxy && picture.shows(state.bodies[kProxy].p()),
      .events = state.counters[kTouches],
      .event = "touch",
      .just_after = "the tip has just met the surface",
      .going_on = tip,
      .unseen = tip + ", out of the picture"};
}

Json TouchRecord::summary() const {
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
  Json touch = {{"contact_s", tick_s * ticks},
                {"of_s", last_ - first_},
                {"touches", touches_},
                {"slips", slips_},
                {"sliding_share", ticks > 0.0 ? static_cast<double>(sliding) / ticks : 0.0},
                {"force_n", spread(force)},
                {"depth_mm", spread(depth)},
                {"unsettled", unsettled_}};
  if (!friction.empty()) touch["friction"] = {{"median", friction.quantile(0.5)}};
  return {{"touch", touch}};
}

std::vector<std::string> TouchRecord::tables() const {
  CsvWriter csv({"time_s", "force_n", "tangential_n", "depth_mm", "speed_mm_s", "sliding", "tip_x_m",
                 "tip_y_m", "tip_z_m", "normal_x", "normal_y", "normal_z"});
  for (const Row& row : rows_)
    csv.row(std::vector<double>{row.time, row.force, row.tangential, mm_from_metres(row.depth),
                                mm_from_metres(row.speed), row.sliding ? 1.0 : 0.0, row.tip.x(), row.tip.y(),
                                row.tip.z(), row.normal.x(), row.normal.y(), row.normal.z()});
  return {csv.content()};
}

std::vector<scene::ClosingLine> TouchRecord::closing_lines(const Json& summary) const {
  const auto& touch = summary["touch"];
  return {
      {"touch",
       fmt::format("touched {} times, {:.1f} of {:.1f} s on the surface, {} slips, peak force {:.1f} N",
                   touch["touches"].get<int>(), touch["contact_s"].get<double>(), touch["of_s"].get<double>(),
                   touch["slips"].get<int>(), touch.value("/force_n/max"_json_pointer, 0.0))}};
}

void add_record(scene::ApplicationSpec& spec) {
  spec.tables = {{kTouchTable, "touch, millisecond by millisecond of contact"}};
  spec.make_record = [](const scene::SceneDescription&) { return std::make_unique<TouchRecord>(); };
  spec.report = play_report;
  spec.page = page_files();
}

}  // namespace palpate::applications::touch
