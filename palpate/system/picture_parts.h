// What the graphics server needs to see and to draw: landmark detection with pose refinement, and the
// compositor.
//
// Made from the rig and the scene; used on the thread that made it (it owns an OpenGL context). Throws where
// no OpenGL is to be had.
#pragma once

#include <memory>

#include "palpate/calibration/charuco.h"
#include "palpate/calibration/overlay_estimate.h"
#include "palpate/compositor/compositor.h"
#include "palpate/compositor/landmark_detector.h"
#include "palpate/graphics_server/graphics_server.h"
#include "palpate/model/rig.h"
#include "palpate/scene/application.h"
#include "palpate/system/calibration_session.h"
#include "palpate/system/outside_view.h"
#include "palpate/system/real_objects.h"

namespace palpate {

class PictureParts {
 public:
  PictureParts(const PictureParts&) = delete;
  PictureParts& operator=(const PictureParts&) = delete;
  // Throws std::invalid_argument where a mesh of the rig's objects cannot be read (RealObjects::read tells it
  // beforehand).
  PictureParts(const Rig& rig, const SceneDescription& scene, std::unique_ptr<Artist> artist,
               Quality quality = Quality::medium);

  PoseRefiner refiner();
  // For a rig with a board, in the refiner's place.
  PoseFinder finder();
  // Draws the frame, with score and rally in its corner unless somebody else shows them.
  FramePainter painter(bool captions = true);
  // How the application carries a state on.
  StatePredictor predictor();
  std::vector<std::string> captions(const WorldState& state) const { return artist_->captions(state); }
  // A drawn frame as seen from the side (outside_view.h), of the size of the camera's picture; drawn once for
  // each frame, when it is first asked for. Valid until the next frame is asked for.
  const OutsidePicture& outside(const FrameRecord& record);
  // The eye it is seen with.
  const Eye& outside_eye() const { return outside_eye_; }

 private:
  // What belongs to one camera.
  struct EyeParts {
    Rig rig;  // as if that camera were the only one
    OverlayKnowledge known;
  };
  void refine(const EyeParts& eye, const CameraImage& image, const Matrix6& covariance, EyePose& pose) const;
  Expected<void> find(const CameraImage& image, const std::optional<Pose<World, CameraOptical>>& near,
                      FrameRecord& record);
  void paint(const CameraImage& image, const CameraImage* right, FrameRecord& record, bool captions);
  RealScene real_things(const FrameRecord& record) const;
  // Nobody knows where the camera is, nor where its picture's virtual things would stand.
  bool lost() const;

  EyeParts left_;
  const Rig& rig_ = left_.rig;
  std::optional<EyeParts> right_;
  SceneDescription scene_;
  std::unique_ptr<Artist> artist_;
  RealObjects objects_;
  Compositor compositor_;
  Eye outside_eye_;
  PlayersCamera players_camera_;
  std::optional<Furniture> furniture_;  // of a table in a room; what a desk stands on nobody knows
  OutsidePicture outside_;
  TriangleMesh outline_;                 // of a desk's table and wall, which nobody would see otherwise
  int lost_ = 0;                         // images in a row without the board
  std::optional<std::string> stranger_;  // the dictionary of another board that lies there
};

// The detector as the calibration session wants it.
FindLandmarks landmark_finder();

}  // namespace palpate
