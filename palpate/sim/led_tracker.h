// How a tracker of linear (1-D) cameras finds LEDs and bodies: planes, triangulation, rigid body fit.
//
// World frame, metres. A linear camera at c looking along f measures along a (unit, across f) the number
//   u = a.(p - c) / f.(p - c),
// which puts the LED on the plane through c with normal a - u f. Three planes meet in the point; its
// covariance is that of the measurements carried through, (H^T H)^-1 su^2 with rows H = (a - u f)^T / f.(p -
// c). The body fit starts from the closed form of Arun, Huang, Blostein (1987) and refines by least squares
// with each LED weighted by its covariance. Pure functions and values, safe from any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "palpate/math/so3.h"

namespace palpate::sim {

struct LinearCamera {
  Vector3 place = Vector3::Zero();
  Vector3 forward = Vector3::UnitZ();
  Vector3 across = Vector3::UnitX();  // the measured direction, unit and perpendicular to forward

  // A camera at `place` looking at `target`; it measures along `direction` as far as that lies across its
  // view.
  static LinearCamera aimed(const Vector3& place, const Vector3& target, const Vector3& direction);

  double depth(const Vector3& p) const { return forward.dot(p - place); }
  double measure(const Vector3& p) const { return across.dot(p - place) / depth(p); }
  // d measure / d p.
  Vector3 gradient(const Vector3& p) const { return (across - measure(p) * forward) / depth(p); }
};

struct LedPoint {
  Vector3 place = Vector3::Zero();
  Matrix3 covariance = Matrix3::Zero();  // m^2
};

// The point on which the planes of measurements `u` (one per camera, each of standard deviation sd) agree
// best in the least-squares sense; exact for three cameras. None where the planes do not meet in one point in
// front of the cameras.
std::optional<LedPoint> triangulate(std::span<const LinearCamera> cameras, std::span<const double> u,
                                    double sd);

// rms length of the triangulation error at `p` per unit of measurement standard deviation, m.
double triangulation_gain(std::span<const LinearCamera> cameras, const Vector3& p);

struct BodyFit {
  Quaternion rotation = Quaternion::Identity();  // body in World
  Vector3 translation = Vector3::Zero();
  // Rotation (rad, World axes, left perturbation) then translation (m).
  Matrix6 covariance = Matrix6::Zero();
  double chi2 = 0.0;  // weighted residual sum; 3 n - 6 expected
};

// Pose of a rigid body from n >= 3 of its LEDs that are not in one line; none otherwise.
std::optional<BodyFit> fit_body(std::span<const Vector3> body, std::span<const LedPoint> seen);

// Covariance of a point at `p_world` fixed to the body, from the covariance of its pose.
Matrix3 point_covariance(const Quaternion& rotation, const Matrix6& pose_covariance, const Vector3& p_body);

}  // namespace palpate::sim
