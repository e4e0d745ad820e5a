// What ping-pong looks like: ball, two-sided bat, handle, and the score. The bat has a blade as real ones do, or a rim
// with strings through which the ball is seen. Graphics thread.
#pragma once

#include "applications/pingpong/settings.h"
#include "palpate/scene/application.h"

namespace palpate::applications::pingpong {

class PingPongView : public scene::SceneView {
 public:
  explicit PingPongView(const scene::SceneDescription& scene);
  std::vector<scene::DrawItem> draw(const scene::SceneState& state) const override;
  std::vector<std::string> looks() const override {
    return {"the bat has a blade", "the bat has strings: the ball is seen through them"};
  }
  void set_look(std::size_t which) override { strung_ = which == kStrung; }
  std::size_t look_at_window() const override { return kStrung; }
  std::vector<std::string> captions(const scene::SceneState& state) const override;
  // The ball flies as it does in the game up to its first contact, with table, wall or bat, and stays there:
  // what comes after an impact nobody knows before it has happened. The bat moves on steadily.
  scene::SceneState predict(const scene::SceneState& state, Duration ahead) const override;

 private:
  static constexpr std::size_t kStrung = 1;  // of looks()
  scene::SceneDescription scene_;
  GameSettings game_;
  scene::TriangleMesh ball_, front_, back_, rim_, strings_, handle_;
  bool strung_ = false;
};

}  // namespace palpate::applications::pingpong
