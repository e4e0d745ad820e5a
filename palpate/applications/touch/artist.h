// What touch looks like: the organ, the tip where it rests on it, the stylus, and the force. Graphics thread.
#pragma once

#include "palpate/applications/touch/organ.h"
#include "palpate/scene/application.h"

namespace palpate::touch {

class TouchArtist : public Artist {
 public:
  explicit TouchArtist(const SceneDescription& scene);
  std::vector<DrawItem> draw(const WorldState& state) const override;
  std::vector<std::string> captions(const WorldState& state) const override;

 private:
  TouchArtist(const SceneDescription& scene, const TriangleMesh& touched);
  TriangleMesh organ_, tip_, plinth_;
  Pose<World, Organ> X_world_rest_;
  TriangleMesh stylus_;
};

}  // namespace palpate::touch
