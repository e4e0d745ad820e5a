// What palpation looks like: the organ as it is dented, the tip, the marks; once a search is over a net in place of the
// organ's surface, and the nodules in it. One thread.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "applications/palpation/liver.h"
#include "applications/palpation/organ_tint.h"
#include "applications/palpation/score.h"
#include "applications/palpation/settings.h"
#include "palpate/scene/application.h"

namespace palpate::applications::palpation {

// The nodules that a state tells of: none until the search is over. Drawn anew when the seed changes.
class RevealedNodules {
 public:
  RevealedNodules(scene::TriangleMesh organ, const PalpationSettings& settings)
      : organ_(std::move(organ)), settings_(settings) {}
  const std::vector<HiddenNodule>& of(const scene::SceneState& state);

 private:
  scene::TriangleMesh organ_;
  PalpationSettings settings_;
  std::int32_t seed_ = 0;
  std::vector<HiddenNodule> nodules_;
};

// Of a state, in the frame Body.
std::vector<Vector3> marks_of(const scene::SceneState& state);

class PalpationView : public scene::SceneView {
 public:
  explicit PalpationView(const scene::SceneDescription& scene);
  PalpationView(const PalpationView&) = delete;  // items refer to its meshes
  PalpationView& operator=(const PalpationView&) = delete;

  std::vector<scene::DrawItem> draw(const scene::SceneState& state) const override;
  std::vector<std::string> captions(const scene::SceneState& state) const override;
  void set_shape(const std::shared_ptr<const scene::Shape>& shape) override { shape_ = shape; }
  // The organ; its net, through which one sees; the stress in its surface.
  std::vector<std::string> looks() const override {
    return {"the organ is drawn", "the organ's net is drawn", "the organ's stress is drawn"};
  }
  void set_look(std::size_t which) override { way_ = static_cast<Way>(which); }

 private:
  enum class Way : std::size_t { organ, net, stress };
  scene::DrawItem organ_item(const scene::SceneState& state) const;
  void add_nodules(const scene::SceneState& state, std::vector<scene::DrawItem>& items) const;
  void add_marks(const scene::SceneState& state, std::vector<scene::DrawItem>& items) const;

  PalpationSettings settings_;
  Pose<World, Body> X_world_rest_;
  scene::TriangleMesh organ_, seen_, net_, tray_, tip_, stylus_, mark_;
  OrganTint tint_;
  std::shared_ptr<const scene::Shape> shape_;
  Way way_ = Way::organ;
  mutable double most_stress_ = 0.0;  // Pa, in the newest picture that shows it
  mutable RevealedNodules revealed_;
  mutable std::array<scene::TriangleMesh, kMostNodules> nodule_meshes_;
  mutable std::int32_t meshes_of_ = 0;  // seed
};

}  // namespace palpate::applications::palpation
