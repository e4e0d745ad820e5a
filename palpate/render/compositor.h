// The augmented picture: the camera's image with its lens undone, and virtual things standing in it.
//
// Real surfaces, the real arm and registered real bodies are known as shapes (phantoms): they hide what is
// behind them, carry the shadows of virtual things and throw theirs on them. The picture is CameraModel's
// pinhole picture: a World point p appears at project_undistorted(X_camera_world p), pixel centres at whole
// numbers, row 0 on top. Light is added and averaged as light; bytes in and out are encoded as the camera
// encodes them. Deterministic to the bit on one version of Mesa. Throws where no OpenGL is to be had. Thread:
// constructed, used and destroyed on one thread; it may share that thread with other users of OpenGL.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/camera_model.h"
#include "palpate/device/devices.h"
#include "palpate/device/holding_hand.h"
#include "palpate/render/arm_shape.h"
#include "palpate/render/room_light.h"
#include "palpate/scene/application.h"

namespace palpate::render {

// A real body of known shape at a registered place: a phantom head, a vise. Mesh frame in World, m.
struct RealBody {
  // Must live as long as it is drawn. Who changes its vertices raises its version.
  const scene::TriangleMesh* mesh = nullptr;
  Quaternion rotation = Quaternion::Identity();
  Vector3 position = Vector3::Zero();
};

// What is known of the real things in view.
struct RealScene {
  std::vector<scene::SceneSurface> surfaces;             // table, wall, ...
  std::optional<ArmConfiguration> arm;                   // at the moment of the image
  std::vector<Vector3> marker_leds;                      // m, marker frame: the stylus carries its plate
  device::HoldingHand hand = device::HoldingHand::none;  // that holds its stylus; hides as the arm does
  double arm_base_below = 0.12;                          // m, ArmBase origin above what the arm stands on
  std::vector<RealBody> bodies;
  // What stands round them in a view from outside, to be seen and no more: it hides nothing virtual, throws
  // no shadow and takes none. Eyes with an image do not see it.
  std::vector<scene::DrawItem> backdrop;
};

struct CompositorSettings {
  device::RoomLight light;
  int samples = 4;  // per pixel of virtual things: 1 (rough edges), 4 or 8
  bool shadows = true;
  int surface_texels = 128;  // along the darkened part of a surface, 16 to 1024
  int map_texels = 512;      // of the shadow maps by which bodies shade bodies, 64 to 4096; 0: they do not
  // Of bodies of many triangles, along the diagonal of their box, of which one vertex each throws their shadow on
  // surfaces (clustered()); 0: every one does.
  int shadow_cells = 0;
  bool real_shadows = true;  // those of real things on surfaces are known: no place gets darker twice
  device::Encoding encoding = device::Encoding::root;
  // Who undoes the camera's lens; where nothing is said the processor if it draws the rest, too. Both agree to two levels.
  std::optional<bool> lens_on_processor;
};

// low: a software renderer keeps up with a camera; medium: the usual; high: with a graphics card.
enum class Quality : std::uint8_t { low, medium, high };
CompositorSettings settings_of(Quality quality);
std::string_view quality_word(Quality quality);
Expected<Quality> parse_quality(std::string_view word);  // wrong use where it is another word
// The same where `auto` leaves the choice to the program: none.
std::string_view quality_choice_word(std::optional<Quality> quality);
Expected<std::optional<Quality>> parse_quality_choice(std::string_view word);

// One view: an image, the calibrated camera that took it (lens undone by its distortion, drawn with its focal
// lengths and centre) and where it was. Without an image the real things are drawn as plain shapes: a view
// from outside.
struct Viewpoint {
  const device::CameraImage* image = nullptr;
  device::CameraModel camera;
  Pose<World, CameraOptical> X_world_camera;
};

class Compositor {
 public:
  explicit Compositor(const CompositorSettings& settings = {});
  ~Compositor();

  // The image must have the camera's size (std::invalid_argument otherwise). rgb_out: packed RGB, row 0 on
  // top.
  void draw(const device::CameraImage& image, const device::CameraModel& camera,
            const Pose<World, CameraOptical>& X_world_camera, std::span<const scene::DrawItem> items,
            const RealScene& real, std::vector<std::uint8_t>& rgb_out);
  // Eyes side by side, the first on the left; all of one size. What they share is drawn once.
  void draw(std::span<const Viewpoint> eyes, std::span<const scene::DrawItem> items, const RealScene& real,
            std::vector<std::uint8_t>& rgb_out);

  // Called at the end of each stage of a picture with its name, a literal; for benchmarks and traces. While somebody
  // watches each stage is waited for, which is a little slower.
  void watch_stages(std::function<void(const char* stage)> watcher);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// One picture twice, side by side: for a display with two eyes where there is one camera. Both eyes then see
// the same, so nothing leaves its place, and nothing has depth. Wrong sizes throw std::invalid_argument.
std::vector<std::uint8_t> biocular(std::span<const std::uint8_t> rgb, int width, int height);

// The first of `eyes` pictures of one size side by side. Wrong sizes throw std::invalid_argument.
std::vector<std::uint8_t> left_eye(std::span<const std::uint8_t> rgb, int width, int height, int eyes);

}  // namespace palpate::render
