// Soft shadows of bodies on a rectangle: how much of the lamp each place of the rectangle cannot see.
//
// The lamp is a disc, sampled at sixteen points; each sample throws the bodies flat onto the rectangle, and
// the samples are averaged. So a shadow is sharp at the contact and softens with distance, as a real one.
// Only the part of the rectangle that the bodies can darken is drawn. World frame, metres. Thread: the
// context's.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "palpate/render/mesh_buffer.h"
#include "palpate/render/room_light.h"

namespace palpate::render {

struct ShadowCaster {
  const MeshBuffer* mesh = nullptr;
  Matrix4f X_world_mesh = Matrix4f::Identity();
  bool closed = true;   // one side of it throws the whole shadow
  bool coarse = false;  // by fewer triangles, where it has them
  bool real = false;    // its own shadow is in the camera's image already
};

// Corner and unit sides; the normal is side_x cross side_y.
struct ShadowReceiver {
  Vector3 corner = Vector3::Zero(), side_x = Vector3::UnitX(), side_y = Vector3::UnitY();
  double width = 1.0, height = 1.0;
};

class PlanarShadow {
 public:
  // `size` texels along each side of the darkened part. `by_processor`: who averages the samples; where nothing is said
  // the processor if it draws the rest, too. Both agree to a level.
  explicit PlanarShadow(int size = 128, std::optional<bool> by_processor = {});

  // False where no virtual body throws a shadow on the rectangle. Leaves its own framebuffer bound.
  bool draw(std::span<const ShadowCaster> casters, const ShadowReceiver& receiver,
            const device::RoomLight& light, const FullScreen& screen);
  // Of the last draw: red, share of the lamp that any body hides; green, that real bodies hide; and the part
  // that virtual ones darken as (x, y, width, height) in metres on the rectangle.
  const Texture& texture() const { return by_processor_ ? averaged_ : result_.texture(); }
  const Vector4f& part() const { return part_; }

 private:
  Program cast_, gather_;
  bool by_processor_;
  Target tiles_, result_;
  Texture averaged_;  // where the processor does it
  std::vector<std::uint8_t> samples_, average_;
  Vector4f part_ = Vector4f::Zero();
};

}  // namespace palpate::render
