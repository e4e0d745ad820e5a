#include "applications/palpation/report.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "applications/palpation/record.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kNextPress_s = 0.005;  // without contact that long: another press
constexpr double kStill_mm_s = 15.0;    // slower, and what is felt is the tissue's own force

struct Ball {
  double x, z, radius;  // mm
  bool found;
};

struct Marks {
  std::vector<Ball> nodules;
  Json right = {{"x_mm", Json::array()}, {"z_mm", Json::array()}}, wrong = right;
};

Marks marks_in(const figures::PlayFolder& play) {
  Marks marks;
  const CsvTable* table = play.raw(kMarkTable);
  if (table == nullptr || !figures::has_columns(*table, {"kind", "x_mm", "z_mm", "radius_mm", "right"}))
    return marks;
  const auto kind = figures::column(*table, "kind"), x = figures::column(*table, "x_mm"),
             z = figures::column(*table, "z_mm"), radius = figures::column(*table, "radius_mm"),
             right = figures::column(*table, "right");
  for (std::size_t i = 0; i < kind.size(); ++i) {
    if (kind[i] < 0.5) {
      marks.nodules.push_back({x[i], z[i], radius[i], right[i] > 0.5});
      continue;
    }
    Json& list = right[i] > 0.5 ? marks.right : marks.wrong;
    list["x_mm"].push_back(x[i]);
    list["z_mm"].push_back(z[i]);
  }
  return marks;
}

// The nodules' rims from above, with a gap between two.
Json rims(const std::vector<Ball>& nodules, bool found) {
  Json rim = {{"x_mm", Json::array()}, {"z_mm", Json::array()}};
  constexpr int kCorners = 36;
  for (const Ball& ball : nodules) {
    if (ball.found != found) continue;
    for (int i = 0; i <= kCorners; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kCorners;
      rim["x_mm"].push_back(ball.x + ball.radius * std::cos(angle));
      rim["z_mm"].push_back(ball.z + ball.radius * std::sin(angle));
    }
    rim["x_mm"].push_back(NAN);
    rim["z_mm"].push_back(NAN);
  }
  return rim;
}

struct Contact {
  std::vector<double> time, force, depth, speed, x, z;
};

Json over_time(const Contact& c) {
  constexpr std::size_t kEvery = 4;
  std::vector<double> time, force, depth;
  for (std::size_t i = 0; i < c.time.size(); ++i) {
    const bool lifted = i > 0 && c.time[i] - c.time[i - 1] > kNextPress_s;
    if (lifted)
      for (auto* list : {&time, &force, &depth}) list->push_back(NAN);
    if (i % kEvery != 0 && !lifted) continue;
    time.push_back(c.time[i] - c.time.front());
    force.push_back(c.force[i]);
    depth.push_back(c.depth[i]);
  }
  return {{"time_s", time}, {"force_n", force}, {"depth_mm", depth}};
}

// Force over depth where the tip hardly moves, and where that was.
void add_curves(const Contact& c, const Marks& marks, Json& data) {
  Json above = {{"depth_mm", Json::array()}, {"force_n", Json::array()}}, beside = above;
  Json pressed = {{"x_mm", Json::array()}, {"z_mm", Json::array()}};
  constexpr std::size_t kEvery = 5;
  for (std::size_t i = 0; i < c.time.size(); i += kEvery) {
    if (c.speed[i] > kStill_mm_s) continue;
    const bool over_one = std::any_of(marks.nodules.begin(), marks.nodules.end(), [&](const Ball& ball) {
      return std::hypot(c.x[i] - ball.x, c.z[i] - ball.z) <= ball.radius;
    });
    Json& curve = over_one ? above : beside;
    curve["depth_mm"].push_back(c.depth[i]);
    curve["force_n"].push_back(c.force[i]);
    pressed["x_mm"].push_back(c.x[i]);
    pressed["z_mm"].push_back(c.z[i]);
  }
  data["curves"] = {{"above", above}, {"beside", beside}};
  data["plan"] = {{"pressed", pressed},
                  {"found", rims(marks.nodules, true)},
                  {"missed", rims(marks.nodules, false)},
                  {"marks", marks.right},
                  {"false_marks", marks.wrong}};
}

}  // namespace

scene::PlayReport play_report(const figures::PlayFolder& play) {
  scene::PlayReport report;
  report.data["presses"] = nullptr;
  const CsvTable* table = play.raw(kPressTable);
  if (table == nullptr ||
      !figures::has_columns(*table, {"time_s", "force_n", "depth_mm", "speed_mm_s", "tip_x_mm", "tip_z_mm"}))
    return report;
  const Contact contact{figures::column(*table, "time_s"),   figures::column(*table, "force_n"),
                        figures::column(*table, "depth_mm"), figures::column(*table, "speed_mm_s"),
                        figures::column(*table, "tip_x_mm"), figures::column(*table, "tip_z_mm")};
  if (contact.time.empty()) return report;
  report.data["presses"] = over_time(contact);
  add_curves(contact, marks_in(play), report.data);
  return report;
}

}  // namespace palpate::applications::palpation
