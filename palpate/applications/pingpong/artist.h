// What ping-pong looks like: ball, two-sided bat, handle, and the score. Graphics thread.
#pragma once

#include "palpate/scene/application.h"

namespace palpate::pingpong {

class PingPongArtist : public Artist {
 public:
  explicit PingPongArtist(const SceneDescription& scene);
  std::vector<DrawItem> draw(const WorldState& state) const override;
  std::vector<std::string> captions(const WorldState& state) const override;
  // The ball flies as it does in the game up to its first contact, with table, wall or bat, and stays there:
  // what comes after a blow nobody knows before it has happened. The bat moves on steadily.
  WorldState predict(const WorldState& state, Duration ahead) const override;

 private:
  SceneDescription scene_;
  TriangleMesh ball_, front_, back_, handle_;
};

}  // namespace palpate::pingpong
