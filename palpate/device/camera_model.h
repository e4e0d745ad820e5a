// A camera: a pinhole, and a lens that bends what it sees.
//
// CameraOptical frame: x right, y down, z forward, metres. Pixels: u right, v down, (0,0) is the CENTRE of
// the first pixel. Pure functions, safe from any thread. Sources: Brown (1966), OpenCV calib3d documentation for the
// order; Kannala and Brandt (2006), "A generic camera model and calibration method for conventional, wide-angle, and
// fish-eye lenses", its radial part, as OpenCV's fisheye module has it; OpenCV's rational model after Claus and Fitzgibbon
// (2005), "A rational function lens distortion model for general cameras", its radial part.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string_view>

#include "palpate/math/pose.h"

namespace palpate::device {

using Pixel = Eigen::Vector2d;

enum class LensKind : std::uint8_t {
  // k1 k2 p1 p2 k3, a polynomial in the distance of (x/z, y/z) from the axis: lenses up to some 110 deg.
  brown,
  // k1 k2 k3 k4: an angle t from the axis is seen at the distance t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8): wide ones.
  fisheye,
  // k1 k2 p1 p2 k3 k4 k5 k6: Brown's, its polynomial divided by 1 + k4 r^2 + k5 r^4 + k6 r^6: lenses up to some 130 deg.
  rational,
};
const char* lens_word(LensKind kind);  // "brown"
std::optional<LensKind> lens_kind(std::string_view word);
inline constexpr std::array<const char*, 3> kLensWords{"brown", "fisheye", "rational"};
// How many coefficients a lens of this kind has.
constexpr std::size_t coefficient_count(LensKind kind) {
  return kind == LensKind::fisheye ? 4 : kind == LensKind::brown ? 5 : 8;
}
inline constexpr std::size_t kMostCoefficients = 8;
using LensCoefficients = std::array<double, kMostCoefficients>;

// How far from the axis a lens is followed: beyond, x/z and y/z grow without bound.
inline constexpr double kWidestAngle = 80.0 * std::numbers::pi / 180.0;  // rad

struct CameraModel {
  int width = 640, height = 480;
  double fx = 560.0, fy = 560.0, cx = 319.5, cy = 239.5;  // px
  LensCoefficients distortion{};                          // those that the kind lacks are 0
  LensKind kind = LensKind::brown;
  bool operator==(const CameraModel&) const = default;

  // Ideal pinhole (no lens): the pixel of the undistorted picture. Needs z > 0.
  Pixel project_undistorted(const Vector3& p) const {
    return {fx * p.x() / p.z() + cx, fy * p.y() / p.z() + cy};
  }
  // Through the lens: the pixel in the camera's image. Needs z > 0.
  Pixel project(const Vector3& p) const;
  // Normalised coordinates (x/z, y/z), with and without the lens.
  Eigen::Vector2d distort(const Eigen::Vector2d& normalised) const;
  // Inverse of distort, by Newton's method; empty where the lens model does not reach (folded back).
  std::optional<Eigen::Vector2d> undistort(const Eigen::Vector2d& distorted) const;
  std::optional<Pixel> undistort_pixel(const Pixel& pixel) const;
  // Of `distortion`, as many as the lens's kind has.
  std::span<const double> coefficients() const {
    return std::span(distortion).first(coefficient_count(kind));
  }
};

// "k1 k2 p1 p2 k3", as coefficients() has them.
const char* coefficient_names(LensKind kind);
// The angle between a pixel's ray and the axis, rad; empty where the lens model does not reach. Also beyond kWidestAngle.
std::optional<double> angle_from_axis(const CameraModel& camera, const Pixel& pixel);

// Nearer than this in front of a camera a point has no sensible pixel.
inline constexpr double kNearestSeen = 0.02;  // m
// The pixel of a point in World, in the undistorted picture of a camera there; empty where it is nearer, or behind.
std::optional<Pixel> drawn_pixel(const CameraModel& camera, const Pose<World, CameraOptical>& X_world_camera,
                                 const Vector3& point);

// Through the lens, with d pixel / d p (2x3, px per metre). Needs z > 0.
Pixel project(const CameraModel& camera, const Vector3& p, Eigen::Matrix<double, 2, 3>& jacobian);

// Parameters of a lens in the order of its covariance: fx fy cx cy (px) and `distortion`; those that its kind lacks are none
// and stay 0.
inline constexpr Eigen::Index kLensParameters = 4 + static_cast<Eigen::Index>(kMostCoefficients);
using LensParameters = Eigen::Matrix<double, kLensParameters, 1>;
// d project / d those parameters, px per unit of each. Needs z > 0.
Eigen::Matrix<double, 2, kLensParameters> lens_jacobian(const CameraModel& camera, const Vector3& p);
// The lens with its parameters changed by so much.
CameraModel changed_lens(CameraModel camera, const LensParameters& by);

// d project_undistorted / d p, 2x3, px per metre.
Eigen::Matrix<double, 2, 3> projection_jacobian(const CameraModel& camera, const Vector3& p);

}  // namespace palpate::device
