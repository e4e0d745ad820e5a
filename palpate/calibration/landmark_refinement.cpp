#include "palpate/calibration/landmark_refinement.h"

#include <cmath>

#include "palpate/estimation/linear_algebra.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr int kHandEye = 6;

Matrix6 inverse(Matrix6 covariance) {
  covariance.diagonal().array() += 1e-18;  // a perfect prior stays invertible
  return inverse_symmetric(covariance);
}

struct RefinementState {
  Pose<CameraMarker, CameraOptical> X;
  std::vector<Pose<World, CameraMarker>> frames;
  std::vector<Vector3> places;
};

template <typename A, typename B>
Pose<A, B> moved(const Pose<A, B>& X, const Vector6& d) {
  return {(so3_exp(d.head<3>()) * X.rotation).normalized(), X.translation + d.tail<3>()};
}

template <typename A, typename B>
Vector6 deviation(const Pose<A, B>& X, const Pose<A, B>& from) {
  Vector6 e;
  e << so3_log(X.rotation * from.rotation.conjugate()), X.translation - from.translation;
  return e;
}

Matrix6 deviation_jacobian(const Vector6& e) {
  Matrix6 J = Matrix6::Identity();
  J.topLeftCorner<3, 3>() = so3_left_jacobian_inverse(e.head<3>());
  return J;
}

struct RefinementProblem {
  const CameraModel& camera;
  const HandEyeCalibration& hand_eye;
  const std::vector<Landmark>& touched;
  const std::vector<LandmarkFrame>& frames;
  const LandmarkRefinementOptions& options;
  Matrix6 hand_eye_information;
  std::vector<Matrix6> frame_information;
  std::vector<Matrix3> place_information;

  // Residual of one sighting in px; false where the landmark is behind the camera.
  bool residual(const RefinementState& x, std::size_t f, const Sighting& seen, Eigen::Vector2d& r,
                Eigen::Matrix<double, 2, 3>& Jp, Vector3& arm_world, Vector3& arm_marker) const {
    arm_world = x.places[seen.landmark] - x.frames[f].translation;
    arm_marker = x.frames[f].rotation.conjugate() * arm_world - x.X.translation;
    const Vector3 p = x.X.rotation.conjugate() * arm_marker;
    if (p.z() < 0.01) return false;
    r = project(camera, p, Jp) - seen.centre;
    return true;
  }

  double loss(double squared, double* weight) const {
    const double length = std::sqrt(squared), k = options.huber;
    if (weight != nullptr) *weight = length <= k ? 1.0 : k / length;
    return length <= k ? squared : k * (2 * length - k);
  }

  double cost(const RefinementState& x) const {
    const Vector6 eh = deviation(x.X, hand_eye.X_marker_camera);
    double sum = eh.dot(hand_eye_information * eh);
    for (std::size_t i = 0; i < touched.size(); ++i) {
      const Vector3 e = x.places[i] - touched[i].place.m;
      sum += e.dot(place_information[i] * e);
    }
    Eigen::Vector2d r;
    Eigen::Matrix<double, 2, 3> Jp;
    Vector3 a, b;
    for (std::size_t f = 0; f < frames.size(); ++f) {
      const Vector6 e = deviation(x.frames[f], frames[f].X_world_marker);
      sum += e.dot(frame_information[f] * e);
      for (const auto& seen : frames[f].sightings)
        if (residual(x, f, seen, r, Jp, a, b))
          sum += loss(r.squaredNorm() / (options.pixel_sd * options.pixel_sd), nullptr);
    }
    return sum;
  }

  struct Frame {
    Matrix6 A;
    Vector6 b;
    MatrixXd C;  // 6 x shared
  };

  // Shared unknowns' normal equations, and each frame's block.
  void linearise(const RefinementState& x, MatrixXd& A, VectorXd& b, std::vector<Frame>& blocks) const {
    const auto n = static_cast<Eigen::Index>(kHandEye + 3 * touched.size());
    A = MatrixXd::Zero(n, n);
    b = VectorXd::Zero(n);
    const Vector6 eh = deviation(x.X, hand_eye.X_marker_camera);
    const Matrix6 Jh = deviation_jacobian(eh);
    A.topLeftCorner<6, 6>() = Jh.transpose() * hand_eye_information * Jh;
    b.head<6>() = Jh.transpose() * (hand_eye_information * eh);
    for (std::size_t i = 0; i < touched.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(kHandEye + 3 * i);
      A.block<3, 3>(at, at) = place_information[i];
      b.segment<3>(at) = place_information[i] * (x.places[i] - touched[i].place.m);
    }
    blocks.resize(frames.size());
    const double per_px = 1.0 / (options.pixel_sd * options.pixel_sd);
    const Matrix3 from_marker = x.X.matrix().transpose();
    for (std::size_t f = 0; f < frames.size(); ++f) {
      auto& block = blocks[f];
      const Vector6 e = deviation(x.frames[f], frames[f].X_world_marker);
      const Matrix6 Je = deviation_jacobian(e);
      block.A = Je.transpose() * frame_information[f] * Je;
      block.b = Je.transpose() * (frame_information[f] * e);
      block.C = MatrixXd::Zero(6, n);
      const Matrix3 to_marker = x.frames[f].matrix().transpose();
      for (const auto& seen : frames[f].sightings) {
        Eigen::Vector2d r;
        Eigen::Matrix<double, 2, 3> Jp;
        Vector3 arm_world, arm_marker;
        if (!residual(x, f, seen, r, Jp, arm_world, arm_marker)) continue;
        double w = 1.0;
        loss(r.squaredNorm() * per_px, &w);
        w *= per_px;
        const Eigen::Matrix<double, 2, 3> Jm = Jp * from_marker, JL = Jm * to_marker;
        Eigen::Matrix<double, 2, 6> Jf, Jx;
        Jf << JL * hat(arm_world), -JL;
        Jx << Jm * hat(arm_marker), -Jm;
        if (!options.correct_hand_eye) Jx.setZero();
        const auto at = static_cast<Eigen::Index>(kHandEye + 3 * seen.landmark);
        block.A += w * Jf.transpose() * Jf;
        block.b += w * Jf.transpose() * r;
        block.C.leftCols<6>() += w * Jf.transpose() * Jx;
        block.C.middleCols<3>(at) += w * Jf.transpose() * JL;
        A.topLeftCorner<6, 6>() += w * Jx.transpose() * Jx;
        A.block<6, 3>(0, at) += w * Jx.transpose() * JL;
        A.block<3, 6>(at, 0) += w * JL.transpose() * Jx;
        A.block<3, 3>(at, at) += w * JL.transpose() * JL;
        b.head<6>() += w * Jx.transpose() * r;
        b.segment<3>(at) += w * JL.transpose() * r;
      }
    }
  }
};

double rms_px(const RefinementProblem& problem, const RefinementState& x, int* inliers) {
  double sum = 0.0;
  int n = 0, good = 0;
  Eigen::Vector2d r;
  Eigen::Matrix<double, 2, 3> Jp;
  Vector3 a, b;
  for (std::size_t f = 0; f < problem.frames.size(); ++f)
    for (const auto& seen : problem.frames[f].sightings)
      if (problem.residual(x, f, seen, r, Jp, a, b)) {
        sum += r.squaredNorm(), ++n;
        good += r.norm() < 4.0 * problem.options.pixel_sd ? 1 : 0;
      }
  if (inliers != nullptr) *inliers = good;
  return n > 0 ? std::sqrt(sum / n) : 0.0;
}

}  // namespace

Matrix6 shared_motion(const std::vector<Vector3>& places, const MatrixXd& covariance) {
  Vector3 mean = Vector3::Zero();
  for (const auto& place : places) mean += place / static_cast<double>(places.size());
  MatrixXd G(3 * static_cast<Eigen::Index>(places.size()), 6);  // d place / d motion
  for (std::size_t i = 0; i < places.size(); ++i)
    G.middleRows<3>(3 * static_cast<Eigen::Index>(i)) << -hat(places[i] - mean), Matrix3::Identity();
  const MatrixXd P = solve_symmetric_columns(gram(G), G.transpose());
  return P * covariance * P.transpose();
}

Expected<Estimate<LandmarkRefinement>> refine_landmarks(const CameraModel& camera,
                                                        const HandEyeCalibration& hand_eye,
                                                        const std::vector<Landmark>& touched,
                                                        const std::vector<LandmarkFrame>& frames,
                                                        const LandmarkRefinementOptions& options) {
  std::vector<int> views(touched.size(), 0);
  int count = 0;
  for (const auto& frame : frames)
    for (const auto& seen : frame.sightings) {
      if (seen.landmark >= touched.size())
        return wrong_use("landmarks: a sighting names landmark {}, but there are {}", seen.landmark,
                         touched.size());
      ++views[seen.landmark], ++count;
    }
  int often = 0;
  for (int v : views) often += v >= 5 ? 1 : 0;
  if (often < 3)
    return refused(
        "landmarks: {} of {} are seen in at least 5 frames, 3 are needed; look at table and wall while "
        "turning the head",
        often, touched.size());

  RefinementProblem problem{camera, hand_eye, touched, frames, options, {}, {}, {}};
  Matrix6 hand_eye_covariance = hand_eye.covariance;
  hand_eye_covariance.diagonal().head<3>().array() += options.shared_rotation_sd * options.shared_rotation_sd;
  hand_eye_covariance.diagonal().tail<3>().array() +=
      options.shared_translation_sd * options.shared_translation_sd;
  problem.hand_eye_information = inverse(hand_eye_covariance);
  for (const auto& frame : frames) problem.frame_information.push_back(inverse(frame.covariance));
  for (const auto& landmark : touched)
    problem.place_information.push_back(inverse_symmetric(landmark.covariance + 1e-18 * Matrix3::Identity()));

  RefinementState x{hand_eye.X_marker_camera, {}, {}};
  for (const auto& frame : frames) x.frames.push_back(frame.X_world_marker);
  for (const auto& landmark : touched) x.places.push_back(landmark.place.m);

  Estimate<LandmarkRefinement> result;
  result.value.sightings = count;
  result.value.rms_px_before = rms_px(problem, x, nullptr);
  double best = problem.cost(x), damping = 1e-6;
  MatrixXd A, S;
  VectorXd b;
  std::vector<RefinementProblem::Frame> blocks;
  result.termination = Termination::iteration_limit;
  bool done = false;
  for (; result.iterations < options.max_iterations && !done; ++result.iterations) {
    problem.linearise(x, A, b, blocks);
    while (true) {
      S = A;
      S.diagonal() *= 1.0 + damping;
      VectorXd g = b;
      std::vector<Matrix6> solved;
      for (const auto& block : blocks) {
        Matrix6 D = block.A;
        D.diagonal() *= 1.0 + damping;
        solved.push_back(inverse_symmetric(D));
        const MatrixXd CD = block.C.transpose() * solved.back();
        S.noalias() -= CD * block.C;
        g.noalias() -= CD * block.b;
      }
      VectorXd step = -solve_symmetric(S, g);
      if (!options.correct_hand_eye) step.head<kHandEye>().setZero();
      RefinementState next = x;
      next.X = moved(x.X, step.head<kHandEye>());
      for (std::size_t i = 0; i < touched.size(); ++i)
        next.places[i] += step.segment<3>(static_cast<Eigen::Index>(kHandEye + 3 * i));
      for (std::size_t f = 0; f < frames.size(); ++f)
        next.frames[f] = moved(x.frames[f], Vector6(-solved[f] * (blocks[f].b + blocks[f].C * step)));
      const double c = problem.cost(next);
      if (c <= best) {
        done = best - c < 1e-10 * best + 1e-15;
        x = next, best = c, damping = std::max(0.1 * damping, 1e-12);
        break;
      }
      if (step.norm() < 1e-12 || damping > 1e8) {
        done = true;
        break;
      }
      damping = std::max(10.0 * damping, 1e-6);
    }
  }
  if (done) result.termination = Termination::converged;

  problem.linearise(x, A, b, blocks);
  S = A;
  for (const auto& block : blocks)
    S.noalias() -= block.C.transpose() * solve_symmetric_columns(block.A, block.C);
  result.covariance = covariance_from_information(S);
  if (!options.correct_hand_eye) {
    result.covariance.topRows<kHandEye>().setZero();
    result.covariance.leftCols<kHandEye>().setZero();
  }
  if (!result.covariance.allFinite() || result.covariance.diagonal().minCoeff() < 0)
    return refused(
        "landmarks: the pictures contradict the touched places (no minimum was found); check which dot is "
        "which");
  auto& value = result.value;
  value.landmarks = touched;
  for (std::size_t i = 0; i < touched.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(kHandEye + 3 * i);
    value.landmarks[i].place.m = x.places[i];
    value.landmarks[i].covariance = result.covariance.block<3, 3>(at, at);
    result.residuals.emplace_back(x.places[i] - touched[i].place.m);
  }
  value.shared =
      shared_motion(x.places, result.covariance.bottomRightCorner(result.covariance.rows() - kHandEye,
                                                                  result.covariance.cols() - kHandEye));
  value.hand_eye = hand_eye;
  if (options.correct_hand_eye) {
    value.hand_eye.X_marker_camera = x.X;
    value.hand_eye.covariance = result.covariance.topLeftCorner<kHandEye, kHandEye>();
  }
  value.rms_px = rms_px(problem, x, &value.inliers);
  return result;
}

}  // namespace palpate
