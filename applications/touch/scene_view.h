// What touch looks like: the organ, the tip where it rests on it, the stylus, and the force. Graphics thread.
#pragma once

#include "applications/touch/organ.h"
#include "palpate/scene/application.h"

namespace palpate::applications::touch {

class TouchView : public scene::SceneView {
 public:
  explicit TouchView(const scene::SceneDescription& scene);
  std::vector<scene::DrawItem> draw(const scene::SceneState& state) const override;
  std::vector<std::string> captions(const scene::SceneState& state) const override;

 private:
  TouchView(const scene::SceneDescription& scene, const scene::TriangleMesh& touched);
  scene::TriangleMesh organ_, tip_, plinth_;
  Pose<World, Organ> X_world_rest_;
  scene::TriangleMesh stylus_;
};

}  // namespace palpate::applications::touch
