// Finds round landmarks in a camera image, each near the place where the rig says it should appear.
//
// A landmark is a bright disc inside a wide dark ring. Its outline in the image is predicted from the pose
// (an ellipse, through the lens); a disc of that outline, softened by the pixel, is fitted to the pixels by
// Least squares over place, brightness and ground. Because the fit moves the projected CENTRE and not the
// ellipse's middle, the perspective bias of an ellipse's centroid does not arise. Brightness is taken linear
// in light, as the camera's encoding says. Where the landmarks of a picture fit badly, softer edges are tried, the same for all of them:
// colours filled in from a Bayer pattern, a lens, motion. A sighting that is too faint, half hidden, crossed by a
// shadow's edge or far from the prediction is left out. Pixels: distorted image, (0,0) the centre of the
// first pixel. Pure functions, any thread; about 10 us a landmark.
#pragma once

#include <span>
#include <vector>

#include "palpate/device/camera_model.h"
#include "palpate/device/devices.h"
#include "palpate/device/light.h"
#include "palpate/rig/rig.h"

namespace palpate::vision {

struct LandmarkDetectorSettings {
  double search_px = 10.0;                             // how far from its prediction a landmark is looked for
  device::Encoding encoding = device::Encoding::root;  // of the camera's bytes
  double least_contrast = 0.08;                        // bright minus dark, linear light of 0..1
  double most_ground = 0.10;      // the ring's light over the disc's; printed black on white has 0.03 to 0.06
  double least_radius_px = 0.45;  // of the short half axis; smaller discs carry no place worth having
  double most_residual = 0.12;    // rms of the fit over the contrast; an undisturbed disc leaves 0.01 to 0.06
};

struct LandmarkSighting {
  std::size_t landmark = 0;                      // index into the landmarks
  device::Pixel centre = device::Pixel::Zero();  // image of the disc's centre, distorted
  Eigen::Matrix2d covariance =
      Eigen::Matrix2d::Zero();  // px^2: the fit's residual, and 0.02 px for what a disc is not
  double contrast = 0.0;        // linear light
  double residual = 0.0;        // rms over the contrast: 0 is perfect
};

// The landmarks in view, in their order. Throws std::invalid_argument when image and camera differ in size.
std::vector<LandmarkSighting> detect_landmarks(const device::CameraImage& image,
                                               const device::CameraModel& camera,
                                               const Pose<World, CameraOptical>& X_world_camera,
                                               std::span<const rig::Landmark> landmarks,
                                               const LandmarkDetectorSettings& settings = {});

// How many of them the camera should see: in front, facing it, inside the picture.
int predicted_landmarks(const device::CameraModel& camera, const Pose<World, CameraOptical>& X_world_camera,
                        std::span<const rig::Landmark> landmarks);

}  // namespace palpate::vision
