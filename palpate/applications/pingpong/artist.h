// What ping-pong looks like: ball, two-sided bat, handle, and the score. Graphics thread.
#pragma once

#include "palpate/scene/application.h"

namespace palpate::pingpong {

class PingPongArtist : public Artist {
 public:
  explicit PingPongArtist(const SceneDescription& scene);
  std::vector<DrawItem> draw(const WorldState& state) const override;
  std::vector<std::string> captions(const WorldState& state) const override;

 private:
  TriangleMesh ball_, front_, back_, handle_;
};

}  // namespace palpate::pingpong
