// What the jelly looks like: it on its stand, and the stylus whose tip rests on it. Graphics thread.
#pragma once

#include "mould.h"

namespace jelly {

class JellyView : public palpate::scene::SceneView {
 public:
  explicit JellyView(const palpate::scene::SceneDescription& scene);
  std::vector<palpate::scene::DrawItem> draw(const palpate::scene::SceneState& state) const override;
  std::vector<std::string> captions(const palpate::scene::SceneState& state) const override;

 private:
  palpate::scene::TriangleMesh jelly_, stand_, stylus_, tip_;
};

}  // namespace jelly
