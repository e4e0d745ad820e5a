#include "applications/pingpong/record.h"

#include <fmt/format.h>

#include <cstdlib>

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/report.h"
#include "applications/pingpong/settings.h"
#include "palpate/math/csv_cells.h"

namespace palpate::applications::pingpong {
namespace {

// What the ball does, without whether it is seen; empty between two balls.
std::string course_of_the_ball(const scene::SceneState& state) {
  const auto& counters = state.counters;
  switch (static_cast<Phase>(counters[kPhase])) {
    case Phase::waiting:
      break;
    case Phase::ready:
      return fmt::format("ball {} waits to be served", counters[kServes] + 1);
    case Phase::incoming:
      return counters[kRally] == 0 ? fmt::format("serve {} on its way to the player", counters[kServes])
                                   : "the ball comes back from the wall";
    case Phase::outgoing:
      return "the ball on its way to the wall";
  }
  return "";
}

}  // namespace

GameRecord::GameRecord(const scene::SceneDescription& scene)
    : bat_radius_(game_settings(scene).bat_radius), ball_({"time_s", "x_m", "y_m", "z_m"}) {}

void GameRecord::add_picture(const scene::SceneState& shown) {
  const auto& ball = shown.bodies[kBall];
  if (shown.body_count == 0 || ball.visible == 0) return;
  Cells row{number_text(shown.time.seconds())};
  put(row, ball.p());
  ball_.row(row);
}

bool GameRecord::in_sight(const scene::ShownPicture& picture) const {
  const auto& ball = picture.state.bodies[kBall];
  const auto& bat = picture.state.bodies[kBat];
  if (!picture.have_state || picture.state.body_count <= kBat || ball.visible == 0) return false;
  if (!picture.shows(ball.p())) return false;
  if (bat.visible == 0) return true;
  // Where the line from eye to ball goes through the bat's plane.
  const Vector3 eye = picture.X_world_camera.translation, sight = ball.p() - eye;
  const Vector3 normal = bat.q() * Vector3::UnitY();
  const double along = normal.dot(bat.p() - eye) / normal.dot(sight);
  if (!(along > 0.0 && along < 1.0)) return true;
  return (eye + along * sight - bat.p()).norm() > bat_radius_;
}

scene::Highlight GameRecord::highlight(const scene::ShownPicture& picture) const {
  const std::string ball = course_of_the_ball(picture.state);
  const std::string nothing = "between two balls";
  return {.in_sight = in_sight(picture),
          .events = picture.state.counters[kHits],
          .event = "hit",
          .just_after = "the bat has just met the ball",
          .going_on = ball.empty() ? nothing : ball,
          .unseen = ball.empty() ? nothing : ball + ", hidden by the bat or out of the picture"};
}

Json GameRecord::summary() const {
  const auto& counters = newest_.counters;
  Json summary = {{"rally",
                   {{"serves", counters[kServes]},
                    {"returned", counters[kReturned]},
                    {"longest", counters[kLongest]},
                    {"hits", counters[kHits]}}}};
  if (counters[kLevel] != 0)
    summary["match"] = {{"serves", counters[kMatchServes]},    {"returned", counters[kMatchReturned]},
                        {"points", counters[kPoints]},         {"best", counters[kBest]},
                        {"level", std::abs(counters[kLevel])}, {"over", counters[kLevel] < 0}};
  return summary;
}

std::vector<scene::ClosingLine> GameRecord::closing_lines(const Json& summary) const {
  const auto& rally = summary["rally"];
  std::string text =
      fmt::format("{} of {} serves returned to the wall, longest rally {} returns in a row",
                  rally["returned"].get<int>(), rally["serves"].get<int>(), rally["longest"].get<int>());
  if (const auto force = summary.find("force"); force != summary.end())  // none: of one of several who played
    text += fmt::format(", peak force {:.1f} N", (*force)["peak_n"].get<double>());
  if (const auto match = summary.find("match"); match != summary.end())
    text += fmt::format("; {} points, level {}", (*match)["points"].get<int>(), (*match)["level"].get<int>());
  return {{"rally", text}};
}

scene::SceneState example_state(const scene::SceneDescription& scene, const Pose<World, Tip>& X_world_tip) {
  const Vector3 left_of_middle(-0.10, game_settings(scene).ball_radius + 0.004, 0.05);  // m
  scene::SceneState state;
  state.body_count = 2;
  state.bodies[kBat].set_p((X_world_tip * Point<Tip>{scene.carried_offset}).m);
  state.bodies[kBat].set_q(X_world_tip.rotation);
  for (const auto& [name, corners] : scene.surfaces)
    if (name == "table")
      state.bodies[kBall].set_p(0.25 * (corners[0] + corners[1] + corners[2] + corners[3]) + left_of_middle);
  return state;
}

void add_record(scene::ApplicationSpec& spec) {
  spec.tables = {{kBallTable, "the ball, frame by frame"}};
  spec.make_record = [](const scene::SceneDescription& scene) { return std::make_unique<GameRecord>(scene); };
  spec.report = play_report;
  spec.page = page_files();
  spec.example_state = example_state;
}

}  // namespace palpate::applications::pingpong
