// What a client shows of an application that it does not have: each body as a plain shape, where the state
// says. Graphics thread.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "palpate/scene/application.h"

namespace palpate::scene {

// A body is a grey sphere with a pin along each of its axes, out of the positive side: x red, y green, z blue.
// A surface that deforms is shown by its vertices: its triangles are known to the application alone (shape.h).
class GenericView : public SceneView {
 public:
  static constexpr double kRadius = 0.020;  // m

  // `application`: its name, as the physics server says it; `shape_vertices`: of the surface that deforms, 0
  // where there is none. Throws std::invalid_argument unless the radius is a number above 0, m.
  explicit GenericView(std::string_view application, std::size_t shape_vertices = 0, double radius = kRadius);
  std::vector<DrawItem> draw(const SceneState& state) const override;
  std::vector<std::string> captions(const SceneState& state) const override;

 private:
  std::string application_;
  double radius_;
  TriangleMesh sphere_;
  std::array<TriangleMesh, 3> pins_;  // along x, y, z
  TriangleMesh surface_;              // vertices alone
};

}  // namespace palpate::scene
