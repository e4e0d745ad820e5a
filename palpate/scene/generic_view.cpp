#include "palpate/scene/generic_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "palpate/core/text.h"

namespace palpate::scene {
namespace {

constexpr Look kGreyLook{{0.45f, 0.45f, 0.45f}, 0.010f, 0.080f, 0.050f};
constexpr std::array<Look, 3> kPinLooks{{{{0.70f, 0.05f, 0.05f}, 0.010f, 0.080f, 0.020f},
                                         {{0.06f, 0.50f, 0.08f}, 0.010f, 0.080f, 0.020f},
                                         {{0.06f, 0.12f, 0.80f}, 0.010f, 0.080f, 0.020f}}};
// In radii of the sphere: from inside of it to where a pin ends, and how thick it is.
constexpr double kPinBegins = 0.8, kPinEnds = 1.7, kPinRadius = 0.16;
constexpr std::size_t kLongestName = 24;  // characters: a caption has to fit a picture of 640 px

}  // namespace

GenericView::GenericView(std::string_view application, std::size_t shape_vertices, double radius)
    : application_(excerpt(application, kLongestName)), radius_(radius) {
  if (!(std::isfinite(radius) && radius > 0.0))
    throw std::invalid_argument(
        fmt::format("generic view: radius of {} m; a number above 0 is expected", radius));
  surface_.vertices.resize(shape_vertices, Vector3::Zero());
  sphere_ = sphere_mesh(radius);
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 unit = Vector3::Unit(axis);
    pins_[static_cast<std::size_t>(axis)] =
        cylinder_mesh(kPinBegins * radius * unit, kPinEnds * radius * unit, kPinRadius * radius);
  }
}

std::vector<DrawItem> GenericView::draw(const SceneState& state) const {
  std::vector<DrawItem> items;
  if (!surface_.vertices.empty()) {
    DrawItem surface{&surface_, kGreyLook};
    surface.deforms = true;
    items.push_back(surface);
  }
  const auto count = static_cast<std::size_t>(std::clamp(state.body_count, 0, SceneState::kBodies));
  for (std::size_t i = 0; i < count; ++i) {
    const BodyState& body = state.bodies[i];
    if (body.visible == 0) continue;
    items.push_back({&sphere_, kGreyLook, body.q(), body.p(), true, radius_});
    for (std::size_t axis = 0; axis < 3; ++axis)
      items.push_back({&pins_[axis], kPinLooks[axis], body.q(), body.p(), true});
  }
  return items;
}

std::vector<std::string> GenericView::captions(const SceneState&) const {
  return {fmt::format("application '{}' is not part of this program:", application_),
          "its bodies are shown as plain shapes"};
}

}  // namespace palpate::scene
