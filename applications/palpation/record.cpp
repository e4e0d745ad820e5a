#include "applications/palpation/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "applications/palpation/palpation.h"
#include "applications/palpation/report.h"
#include "palpate/core/csv.h"
#include "palpate/core/statistics.h"
#include "palpate/core/units.h"

namespace palpate::applications::palpation {

PalpationRecord::PalpationRecord(const scene::SceneDescription& scene)
    : settings_(palpation_settings(scene)), revealed_(pressed_mesh(scene), settings_) {}

void PalpationRecord::add_state(const scene::SceneState& state) {
  last_ = state;
  created_nj_ = std::max(created_nj_, state.counters[kCreatedNj]);
  if (state.counters[kNoduleSeed] > 0 && !(over_ && shown_.counters[kTrial] == state.counters[kTrial])) {
    over_ = true;
    shown_ = state;
  }
  if (state.continuous.touching == 0) return;
  const auto& organ = state.bodies[kOrgan];
  const auto& tip = state.bodies[kTip];
  rows_.push_back({state.time.seconds(), Vector3(state.continuous.force.data()).norm(),
                   1e-6 * state.counters[kDepthUm], tip.v().norm(),
                   organ.q().conjugate() * (tip.p() - organ.p())});
}

scene::Highlight PalpationRecord::highlight(const scene::ShownPicture& picture) const {
  const auto& state = picture.state;
  const bool shown = state.counters[kNoduleSeed] > 0;
  const std::string what = shown                          ? "the nodules and the marks, after the search"
                           : state.counters[kForceMn] > 0 ? "the tip presses into the organ"
                                                          : "the tip above the organ";
  return {.in_sight = picture.have_state && state.body_count > kTip && picture.shows(state.bodies[kTip].p()),
          .events = state.counters[kMarks],
          .event = "mark",
          .just_after = "a place has just been marked",
          .going_on = what,
          .unseen = what + ", out of the picture"};
}

std::vector<std::string> PalpationRecord::tables() const {
  CsvWriter presses({"time_s", "force_n", "depth_mm", "speed_mm_s", "tip_x_mm", "tip_y_mm", "tip_z_mm"});
  for (const Row& row : rows_)
    presses.row(std::vector<double>{row.time, row.force, mm_from_metres(row.depth), mm_from_metres(row.speed),
                                    mm_from_metres(row.tip.x()), mm_from_metres(row.tip.y()),
                                    mm_from_metres(row.tip.z())});
  CsvWriter places({"kind", "x_mm", "y_mm", "z_mm", "radius_mm", "right"});
  const auto add = [&](double kind, const Vector3& at, double radius, bool right) {
    places.row(std::vector<double>{kind, mm_from_metres(at.x()), mm_from_metres(at.y()),
                                   mm_from_metres(at.z()), mm_from_metres(radius), right ? 1.0 : 0.0});
  };
  const auto marks = marks_of(judged());
  const auto& nodules = revealed_.of(judged());
  const double within = settings_.rules.within;
  for (const auto& nodule : nodules)
    add(0.0, nodule.above, nodule.ball.radius,
        std::any_of(marks.begin(), marks.end(),
                    [&](const Vector3& mark) { return (mark - nodule.above).norm() <= within; }));
  for (const auto& mark : marks)
    add(1.0, mark, 0.0, std::any_of(nodules.begin(), nodules.end(), [&](const HiddenNodule& nodule) {
          return (mark - nodule.above).norm() <= within;
        }));
  return {presses.content(), places.content()};
}

Json PalpationRecord::summary() const {
  const auto& c = judged().counters;
  ErrorSummary force;
  double deepest = 0.0;
  for (const Row& row : rows_) {
    force.add(row.force);
    deepest = std::max(deepest, row.depth);
  }
  const auto known = [&](Json value) { return over_ ? value : Json(nullptr); };
  const auto nodules = static_cast<int>(revealed_.of(judged()).size());
  Json told{{"over", over_},
            {"trial", c[kTrial]},
            {"nodules", known(nodules)},
            {"found", known(c[kFound])},
            {"missed", known(nodules - c[kFound])},
            {"marks", c[kMarks]},
            {"false_alarms", known(c[kFalseAlarms])},
            {"position_error_mm_median", c[kErrorUm] >= 0 ? Json(1e-3 * c[kErrorUm]) : Json(nullptr)},
            {"seconds", 1e-3 * c[kSearchMs]},
            {"path_m", 1e-3 * c[kPathMm]},
            {"presses", c[kTouches]},
            {"force_p95_n", force.empty() ? Json(nullptr) : Json(force.quantile(0.95))},
            {"force_max_n", force.empty() ? Json(nullptr) : Json(force.quantile(1.0))},
            {"hard_presses", c[kHardPresses]},
            {"depth_mm_max", mm_from_metres(deepest)},
            {"energy_created_j", 1e-9 * created_nj_}};
  if (const auto level = level_told(settings_, judged())) told["level"] = *level;
  return {{"palpation", std::move(told)}};
}

std::vector<scene::ClosingLine> PalpationRecord::closing_lines(const Json& summary) const {
  const auto& p = summary["palpation"];
  const std::string trial = p["trial"].get<int>() > 1 ? fmt::format("trial {}: ", p["trial"].get<int>()) : "";
  const std::string level = p.contains("level") ? fmt::format(" at level {}", p["level"].get<int>()) : "";
  if (!p["over"].get<bool>() && p["seconds"].get<double>() <= 0.0)
    return {{"palpation",
             fmt::format("{}the search{} was not begun: the organ was never touched", trial, level)}};
  if (!p["over"].get<bool>())
    return {{"palpation", fmt::format("{}the search{} was not over after {:.1f} s, {} places marked", trial,
                                      level, p["seconds"].get<double>(), p["marks"].get<int>())}};
  return {{"palpation",
           fmt::format("{}found {} of {} nodules{}, {} false alarms, in {:.1f} s with {} presses", trial,
                       p["found"].get<int>(), p["nodules"].get<int>(), level, p["false_alarms"].get<int>(),
                       p["seconds"].get<double>(), p["presses"].get<int>())}};
}

void add_record(scene::ApplicationSpec& spec) {
  spec.tables = {{kPressTable, "presses, millisecond by millisecond of contact"},
                 {kMarkTable, "nodules and marks"}};
  spec.make_record = [](const scene::SceneDescription& scene) {
    return std::make_unique<PalpationRecord>(scene);
  };
  spec.report = play_report;
  spec.page = page_files();
}

}  // namespace palpate::applications::palpation
