// What ping-pong looks like: ball, two-sided bat, handle, and the score. Graphics thread.
#pragma once

#include "applications/pingpong/settings.h"
#include "palpate/scene/application.h"

namespace palpate::applications::pingpong {

class PingPongView : public scene::SceneView {
 public:
  explicit PingPongView(const scene::SceneDescription& scene);
  std::vector<scene::DrawItem> draw(const scene::SceneState& state) const override;
  std::vector<std::string> captions(const scene::SceneState& state) const override;
  // The ball flies as it does in the game up to its first contact, with table, wall or bat, and stays there:
  // what comes after an impact nobody knows before it has happened. The bat moves on steadily.
  scene::SceneState predict(const scene::SceneState& state, Duration ahead) const override;

 private:
  scene::SceneDescription scene_;
  GameSettings game_;
  scene::TriangleMesh ball_, front_, back_, handle_;
};

}  // namespace palpate::applications::pingpong
