// What a file of another program holds, in SI units: poses, points, a lens or one transform.
//
// Values; any thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "palpate/device/camera_model.h"
#include "palpate/device/pose_file.h"

namespace palpate::formats {

// Of a tracked body or camera. Each maps its coordinates to those of the frame it is reported in.
struct Poses {
  std::vector<device::StampedPose> poses;
  bool has_time = false;     // else time_s is the row's number
  std::size_t left_out = 0;  // rows in which it was hidden
};

struct Points {
  std::vector<Vector3> places;      // m
  std::vector<std::string> labels;  // one each, or none at all
};

// A camera and the bend of its lens (device/camera_model.h): docs/theory/camera.md.
struct Lens {
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;  // px
  device::LensCoefficients distortion{};
  device::LensKind kind = device::LensKind::brown;
  std::optional<std::array<int, 2>> size;  // width, height, px; not every form says it
};

struct Transform {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();  // translation in m
};

struct Content {
  std::string form;  // "a TUM trajectory"
  // What is known of its frames and units, for a person: "t x y z qx qy qz qw, s and m".
  std::string told;
  std::variant<Poses, Points, Lens, Transform> value;
};

}  // namespace palpate::formats
