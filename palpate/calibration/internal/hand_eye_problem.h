// The least-squares problem of hand-eye calibration: hand(t + delay) X = Z eye(t) over two streams of poses.
//
// Six residuals for each eye pose that two hand poses enclose, in the camera's axes: rotation
// log((hand X)^-1 Z eye) in rad, then translation in m; whitened by a 6x6 matrix and put through a Cauchy
// loss. Unknowns: X rotation (left perturbation, CameraMarker
// axes), X translation, Z rotation (World axes), Z translation, delay in s. Poses are sorted by time. Pure
// functions.
#pragma once

#include <vector>

#include "palpate/device/pose_file.h"
#include "palpate/math/levenberg_marquardt.h"

namespace palpate::calibration {

constexpr int kHandEyeUnknowns = 13;
using HandEyeNormal = Eigen::Matrix<double, kHandEyeUnknowns, kHandEyeUnknowns>;
using HandEyeEquations = NormalEquations<kHandEyeUnknowns>;
using HandEyeUnknowns = Eigen::Matrix<double, kHandEyeUnknowns, 1>;
using HandEyeJacobian = Eigen::Matrix<double, 6, kHandEyeUnknowns>;

// Cauchy loss c^2 log(1 + d^2 / c^2) of the whitened squared residual d^2, which is about 6 for an honest
// pose: c^2 = 24 keeps 95 % of the efficiency on normal noise and bounds what a blunder can pull.
constexpr double kHandEyeCauchy = 24.0;

// By time; poses of equal time once.
void sort_by_time(std::vector<device::StampedPose>& poses);

// Leaves out the few poses whose time lies far beyond the others' (a wrong stamp stretches a stream to hours,
// and the search for the delay with it); how many. Sorted poses.
std::size_t drop_stray_times(std::vector<device::StampedPose>& poses);

// The hand between two of its poses.
struct HandAt {
  Quaternion R = Quaternion::Identity();
  Vector3 t = Vector3::Zero();
  Vector3 w = Vector3::Zero(), v = Vector3::Zero();  // angular velocity and velocity, World axes
};
// False where no two hand poses at most max_gap_s apart enclose the time, and none is of that very time.
bool hand_at(const std::vector<device::StampedPose>& hand, double time_s, double max_gap_s, HandAt& out);

// The eye poses that the hand stream encloses at this delay go to `kept`; the hand's places at them.
std::vector<HandAt> enclosed(const std::vector<device::StampedPose>& hand,
                             const std::vector<device::StampedPose>& eye, double delay, double max_gap_s,
                             std::vector<device::StampedPose>& kept);

struct HandEyeState {
  Quaternion Rx = Quaternion::Identity(), Rz = Quaternion::Identity();
  Vector3 tx = Vector3::Zero(), tz = Vector3::Zero();
  double delay = 0.0;

  HandEyeState moved(const HandEyeUnknowns& d) const;
};

Vector6 hand_eye_residual(const HandEyeState& x, const HandAt& hand, const device::StampedPose& eye,
                          HandEyeJacobian* J);

// One problem: the eye poses that the hand stream encloses at every delay tried.
struct HandEyeProblem {
  const std::vector<device::StampedPose>& hand;
  std::vector<device::StampedPose> eye;
  double max_gap_s;
  bool free_delay;
  Matrix6 whiten = Matrix6::Identity();

  // Poses whose moment falls into a gap at this delay do not count; they are few, being at the ends.
  template <typename F>
  void each(const HandEyeState& x, F&& f) const {
    HandAt at;
    for (std::size_t i = 0; i < eye.size(); ++i)
      if (hand_at(hand, eye[i].time_s + x.delay, max_gap_s, at)) f(i, at);
  }

  // Mean loss, so that delays at which fewer poses count are not favoured; with the equations where given.
  double evaluate(const HandEyeState& x, HandEyeEquations* equations) const;
  std::vector<Vector6> residuals(const HandEyeState& x) const;  // not whitened
  LeastSquaresResult solve(HandEyeState& x, int most_iterations) const;
};

// Inverse square root of the residuals' robust scatter, scaled so that the middle residual counts as honest;
// without `before`, or from few residuals, rotation and translation have a scale each and no more.
Matrix6 hand_eye_whitening(const std::vector<Vector6>& residuals, const Matrix6* before);

}  // namespace palpate::calibration
