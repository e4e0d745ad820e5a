// What is kept of a game of ping-pong: where the ball was in each picture, how the rallies went, and which pictures
// show the ball. One thread.
#pragma once

#include <memory>

#include "palpate/core/csv.h"
#include "palpate/scene/application_registry.h"

namespace palpate::applications::pingpong {

// The place of the ball, where there is one, in each picture.
inline constexpr const char* kBallTable = "ball.csv";

class GameRecord : public scene::PlayRecord {
 public:
  explicit GameRecord(const scene::SceneDescription& scene);

  void add_state(const scene::SceneState& state) override { newest_ = state; }
  void add_picture(const scene::SceneState& shown) override;

  // In sight: the ball's centre is inside the picture and the bat does not hide it.
  scene::Highlight highlight(const scene::ShownPicture& picture) const override;
  std::vector<std::string> tables() const override { return {ball_.content()}; }
  // "rally": serves, returned, longest, hits.
  Json summary() const override;
  std::vector<scene::ClosingLine> closing_lines(const Json& summary) const override;

 private:
  bool in_sight(const scene::ShownPicture& picture) const;

  double bat_radius_;
  CsvWriter ball_;
  scene::SceneState newest_;
};

// The ball has just touched the table, left of its middle; the bat is at the stylus.
scene::SceneState example_state(const scene::SceneDescription& scene, const Pose<World, Tip>& X_world_tip);

// Record, table, report and example of the game.
void add_record(scene::ApplicationSpec& spec);

}  // namespace palpate::applications::pingpong
