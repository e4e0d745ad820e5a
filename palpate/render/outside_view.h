// The play as somebody sees it who looks on from the side: where they stand, and the player's camera, which
// only they can see.
//
// World frame, m. Pure but for the meshes that a PlayersCamera owns; one thread.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/device/camera_model.h"
#include "palpate/render/compositor.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"

namespace palpate::render {

struct OutsidePicture {
  std::uint64_t frame = 0;  // FrameRecord::number
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // row 0 on top; empty: nothing is known of the play yet
};

// To the left of the player and a little behind, so that table, wall and the player's head are in view:
// measured in lengths of the table, whose corners are in touching order from the player's left. Throws
// std::invalid_argument where they span nothing.
Viewpoint onlooker(const std::array<Vector3, 4>& table, int width, int height);
// A scene's table, or the first surface where none bears that name; throws std::invalid_argument where there
// is no surface at all.
const scene::SceneSurface& table_of(const std::vector<scene::SceneSurface>& surfaces);
// The same for a scene's table.
Viewpoint onlooker(const std::vector<scene::SceneSurface>& surfaces, int width, int height);

// Somebody who stands there at first and walks round the play, looking at its middle.
class Onlooker {
 public:
  explicit Onlooker(const std::vector<scene::SceneSurface>& surfaces, int width, int height);

  const Viewpoint& viewpoint() const { return viewpoint_; }
  // By so many rad to their right and upwards; never lower than the table, nor quite above it.
  void walk(double right, double up);
  // Nearer by so many notches of a wheel, or farther.
  void approach(double notches);

 private:
  void look();

  Viewpoint viewpoint_;
  Vector3 target_, back_, right_, up_;       // World; directions are the table's
  double farthest_, way_, turned_, raised_;  // m, m, rad, rad
};

// A small camera with the pyramid that it sees: apex in its centre, edges through the corners of its picture
// (undistorted, as it is drawn), with a mark above the upper side.
// On a head with two cameras there are two of them, and two pyramids.
class PlayersCamera {
 public:
  static constexpr double kSightLength = 0.30;  // m, to the pyramid's base

  // worn: on a head, which is drawn, too.
  PlayersCamera(const device::CameraModel& camera, bool worn);
  // A pair, worn.
  PlayersCamera(const device::CameraModel& left, const device::CameraModel& right,
                const Pose<CameraOptical, rig::RightCamera>& X_left_right);
  // X_world_camera: of a pair the left one's. A right camera that is silent has no pyramid. Valid as long as
  // this object stays where it is.
  std::vector<scene::DrawItem> items(const Pose<World, CameraOptical>& X_world_camera,
                                     bool right_sees = true) const;

 private:
  scene::TriangleMesh head_, body_, sight_, right_sight_;
};

// What a table that hangs in the air lacks: its board and legs, the floor on which they stand, and the shade
// under it. Its height is presumed, for nobody measures it. World frame.
class Furniture {
 public:
  static constexpr double kTableHeight = 0.74;  // m, of the board's upper side above the floor

  // The table's corners in touching order; `lamp` throws its shade. Throws std::invalid_argument where the
  // corners span nothing.
  Furniture(const std::array<Vector3, 4>& table, const Vector3& lamp);
  // For RealScene::backdrop; valid as long as this object stays where it is.
  std::vector<scene::DrawItem> items() const;

 private:
  scene::TriangleMesh floor_, shade_, legs_;
};

// The four corners of the pyramid's base, CameraOptical: of the picture's upper left, upper right, lower
// right and lower left.
std::array<Vector3, 4> sight_corners(const device::CameraModel& camera);

}  // namespace palpate::render
