// What touch looks like: the organ, the tip where it rests on it, the stylus; where it touches, a ring on the surface
// and a line along the force on the hand, both larger the larger the force. The real arm's end hides the tip, but not
// these. Graphics thread.
#pragma once

#include <array>

#include "applications/touch/organ.h"
#include "palpate/scene/application.h"

namespace palpate::applications::touch {

class TouchView : public scene::SceneView {
 public:
  explicit TouchView(const scene::SceneDescription& scene);
  std::vector<scene::DrawItem> draw(const scene::SceneState& state) const override;
  std::vector<std::string> captions(const scene::SceneState& state) const override;

 private:
  static constexpr std::size_t kForces = 16;  // steps of the force that is drawn
  void add_contact(const scene::SceneState& state, std::vector<scene::DrawItem>& items) const;
  TouchView(const scene::SceneDescription& scene, const scene::TriangleMesh& touched);
  scene::TriangleMesh organ_;
  scene::Look look_;
  scene::TriangleMesh tip_, plinth_;
  Pose<World, Organ> X_world_rest_;
  scene::TriangleMesh stylus_;
  std::array<scene::TriangleMesh, kForces> rings_, lines_;  // axis y, from the contact on
};

}  // namespace palpate::applications::touch
