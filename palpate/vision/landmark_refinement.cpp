#include "palpate/vision/landmark_refinement.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <optional>

#include "palpate/math/linear_algebra.h"

namespace palpate::vision {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double kLeastVariance = 1e-18;  // m^2: a perfect touch stays invertible
constexpr int kTouchRounds = 6;
constexpr double kSettled = 0.03;  // of the hand's sd: far less than what so few touches tell
constexpr Eigen::Index kLens = device::kLensParameters, kHandEye = 6;
constexpr Eigen::Index kPlaces = kLens + kHandEye;  // of all unknowns that frames share, the landmarks' first

Matrix6 inverse(Matrix6 covariance) {
  covariance.diagonal().array() += 1e-18;  // a perfect prior stays invertible
  return inverse_symmetric(covariance);
}

struct RefinementState {
  device::CameraModel lens;
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

device::LensParameters lens_difference(const device::CameraModel& a, const device::CameraModel& b) {
  device::LensParameters d;
  d << a.fx - b.fx, a.fy - b.fy, a.cx - b.cx, a.cy - b.cy, Eigen::Matrix<double, 5, 1>::Zero();
  for (std::size_t i = 0; i < a.distortion.size(); ++i)
    d[4 + static_cast<Eigen::Index>(i)] = a.distortion[i] - b.distortion[i];
  return d;
}

Matrix6 deviation_jacobian(const Vector6& e) {
  Matrix6 J = Matrix6::Identity();
  J.topLeftCorner<3, 3>() = so3_left_jacobian_inverse(e.head<3>());
  return J;
}

struct RefinementProblem {
  const rig::CameraCalibration& camera;
  const rig::HandEyeCalibration& hand_eye;
  const std::vector<rig::Landmark>& touched;
  const std::vector<LandmarkFrame>& frames;
  const LandmarkRefinementOptions& options;
  Eigen::Matrix<double, kLens, kLens> lens_information;
  Matrix6 hand_eye_information;
  std::vector<Matrix6> frame_information;
  std::vector<Matrix3> place_information;
  std::array<bool, kPlaces> held{};  // of lens and hand-eye: what stays as it is

  struct Miss {
    Eigen::Vector2d r;               // px
    Eigen::Matrix2d weight;          // inverse of its covariance
    Eigen::Matrix<double, 2, 3> Jp;  // d r / d in_camera
    Vector3 in_camera, arm_world, arm_marker;
    double squared() const { return r.dot(weight * r); }
  };

  // Of one sighting; nothing where the landmark is behind the camera.
  std::optional<Miss> miss(const RefinementState& x, std::size_t f, const Sighting& seen) const {
    Miss m;
    m.arm_world = x.places[seen.landmark] - x.frames[f].translation;
    m.arm_marker = x.frames[f].rotation.conjugate() * m.arm_world - x.X.translation;
    m.in_camera = x.X.rotation.conjugate() * m.arm_marker;
    if (m.in_camera.z() < 0.01) return std::nullopt;
    m.r = device::project(x.lens, m.in_camera, m.Jp) - seen.centre;
    m.weight =
        (seen.covariance + options.pixel_sd * options.pixel_sd * Eigen::Matrix2d::Identity()).inverse();
    return m;
  }

  double loss(double squared, double* weight) const {
    const double length = std::sqrt(squared), k = options.huber;
    if (weight != nullptr) *weight = length <= k ? 1.0 : k / length;
    return length <= k ? squared : k * (2 * length - k);
  }

  double cost(const RefinementState& x) const {
    const Vector6 eh = deviation(x.X, hand_eye.X_marker_camera);
    const device::LensParameters el = lens_difference(x.lens, camera.model);
    double sum = eh.dot(hand_eye_information * eh) + el.dot(lens_information * el);
    for (std::size_t i = 0; i < touched.size(); ++i) {
      const Vector3 e = x.places[i] - touched[i].place.m;
      sum += e.dot(place_information[i] * e);
    }
    for (std::size_t f = 0; f < frames.size(); ++f) {
      const Vector6 e = deviation(x.frames[f], frames[f].X_world_marker);
      sum += e.dot(frame_information[f] * e);
      for (const auto& seen : frames[f].sightings)
        if (const auto m = miss(x, f, seen)) sum += loss(m->squared(), nullptr);
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
    const auto n = kPlaces + 3 * static_cast<Eigen::Index>(touched.size());
    A = MatrixXd::Zero(n, n);
    b = VectorXd::Zero(n);
    const Vector6 eh = deviation(x.X, hand_eye.X_marker_camera);
    const Matrix6 Jh = deviation_jacobian(eh);
    A.topLeftCorner<kLens, kLens>() = lens_information;
    b.head<kLens>() = lens_information * lens_difference(x.lens, camera.model);
    A.block<kHandEye, kHandEye>(kLens, kLens) = Jh.transpose() * hand_eye_information * Jh;
    b.segment<kHandEye>(kLens) = Jh.transpose() * (hand_eye_information * eh);
    for (std::size_t i = 0; i < touched.size(); ++i) {
      const auto at = kPlaces + 3 * static_cast<Eigen::Index>(i);
      A.block<3, 3>(at, at) = place_information[i];
      b.segment<3>(at) = place_information[i] * (x.places[i] - touched[i].place.m);
    }
    blocks.resize(frames.size());
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
        const auto m = miss(x, f, seen);
        if (!m) continue;
        double w = 1.0;
        loss(m->squared(), &w);
        const Eigen::Matrix2d W = w * m->weight;
        const Eigen::Matrix<double, 2, 3> Jm = m->Jp * from_marker, JL = Jm * to_marker;
        Eigen::Matrix<double, 2, 6> Jf;
        Jf << JL * hat(m->arm_world), -JL;
        Eigen::Matrix<double, 2, kPlaces> Jq;  // lens and hand-eye
        Jq << device::lens_jacobian(x.lens, m->in_camera), Jm * hat(m->arm_marker), -Jm;
        for (Eigen::Index k = 0; k < kPlaces; ++k)
          if (held[static_cast<std::size_t>(k)]) Jq.col(k).setZero();
        const auto at = kPlaces + 3 * static_cast<Eigen::Index>(seen.landmark);
        const Eigen::Matrix<double, 6, 2> JfW = Jf.transpose() * W;
        const Eigen::Matrix<double, kPlaces, 2> JqW = Jq.transpose() * W;
        const Eigen::Matrix<double, 3, 2> JLW = JL.transpose() * W;
        block.A += JfW * Jf;
        block.b += JfW * m->r;
        block.C.leftCols<kPlaces>() += JfW * Jq;
        block.C.middleCols<3>(at) += JfW * JL;
        A.topLeftCorner<kPlaces, kPlaces>() += JqW * Jq;
        A.block<kPlaces, 3>(0, at) += JqW * JL;
        A.block<3, kPlaces>(at, 0) += JLW * Jq;
        A.block<3, 3>(at, at) += JLW * JL;
        b.head<kPlaces>() += JqW * m->r;
        b.segment<3>(at) += JLW * m->r;
      }
    }
  }
};

double rms_px(const RefinementProblem& problem, const RefinementState& x, int* inliers) {
  double sum = 0.0;
  int n = 0, good = 0;
  for (std::size_t f = 0; f < problem.frames.size(); ++f)
    for (const auto& seen : problem.frames[f].sightings)
      if (const auto m = problem.miss(x, f, seen)) {
        sum += m->r.squaredNorm(), ++n;
        good += m->squared() < 16.0 ? 1 : 0;
      }
  if (inliers != nullptr) *inliers = good;
  return n > 0 ? std::sqrt(sum / n) : 0.0;
}

// Sightings in all; refused where too few landmarks are seen often enough.
Expected<int> count_sightings(const std::vector<rig::Landmark>& touched,
                              const std::vector<LandmarkFrame>& frames) {
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
  return count;
}

void add_information(RefinementProblem& problem) {
  const auto& options = problem.options;
  // Where a lens's covariance says that a parameter has no variance, it was held there and stays so.
  Eigen::MatrixXd lens_covariance = Eigen::MatrixXd::Zero(kLens, kLens);
  if (problem.camera.covariance.rows() == kLens && problem.camera.covariance.cols() == kLens)
    lens_covariance = problem.camera.covariance;
  for (Eigen::Index k = 0; k < kPlaces; ++k)
    problem.held[static_cast<std::size_t>(k)] =
        k < kLens ? !(lens_covariance(k, k) > 0.0) : !options.correct_hand_eye;
  problem.lens_information = covariance_from_information(lens_covariance);  // an inverse, scaled
  Matrix6 hand_eye_covariance = problem.hand_eye.covariance;
  hand_eye_covariance.diagonal().head<3>().array() += options.shared_rotation_sd * options.shared_rotation_sd;
  hand_eye_covariance.diagonal().tail<3>().array() +=
      options.shared_translation_sd * options.shared_translation_sd;
  problem.hand_eye_information = inverse(hand_eye_covariance);
  for (const auto& frame : problem.frames) problem.frame_information.push_back(inverse(frame.covariance));
  for (const auto& landmark : problem.touched)
    problem.place_information.push_back(
        inverse_symmetric(landmark.covariance + kLeastVariance * Matrix3::Identity()));
}

// Levenberg's iteration; frames are eliminated, so that each step solves for what all of them share.
class Refinement {
 public:
  Refinement(const RefinementProblem& problem, int most)
      : problem_(problem), x_{problem.camera.model, problem.hand_eye.X_marker_camera, {}, {}} {
    for (const auto& frame : problem.frames) x_.frames.push_back(frame.X_world_marker);
    for (const auto& landmark : problem.touched) x_.places.push_back(landmark.place.m);
    rms_px_before_ = rms_px(problem, x_, nullptr);
    best_ = problem.cost(x_);
    for (; iterations_ < most && !done_; ++iterations_) {
      problem.linearise(x_, A_, b_, blocks_);
      while (!step()) damping_ = std::max(10.0 * damping_, 1e-6);
    }
  }
  const RefinementState& state() const { return x_; }
  double rms_px_before() const { return rms_px_before_; }
  int iterations() const { return iterations_; }
  bool converged() const { return done_; }

  // Of what frames share; what is held has none.
  MatrixXd covariance() {
    problem_.linearise(x_, A_, b_, blocks_);
    MatrixXd S = A_;
    for (const auto& block : blocks_)
      S.noalias() -= block.C.transpose() * solve_symmetric_columns(block.A, block.C);
    MatrixXd covariance = covariance_from_information(S);
    for (Eigen::Index k = 0; k < kPlaces; ++k)
      if (problem_.held[static_cast<std::size_t>(k)]) {
        covariance.row(k).setZero();
        covariance.col(k).setZero();
      }
    return covariance;
  }

 private:
  // False: it led upwards, and a shorter one is to be tried.
  bool step() {
    MatrixXd S = A_;
    S.diagonal() *= 1.0 + damping_;
    VectorXd g = b_;
    std::vector<Matrix6> solved;
    for (const auto& block : blocks_) {
      Matrix6 D = block.A;
      D.diagonal() *= 1.0 + damping_;
      solved.push_back(inverse_symmetric(D));
      const MatrixXd CD = block.C.transpose() * solved.back();
      S.noalias() -= CD * block.C;
      g.noalias() -= CD * block.b;
    }
    VectorXd step = -solve_symmetric(S, g);
    for (Eigen::Index k = 0; k < kPlaces; ++k)
      if (problem_.held[static_cast<std::size_t>(k)]) step[k] = 0.0;
    const RefinementState next = moved_by(step, solved);
    const double c = problem_.cost(next);
    if (c <= best_) {
      done_ = best_ - c < 1e-10 * best_ + 1e-15;
      x_ = next, best_ = c, damping_ = std::max(0.1 * damping_, 1e-12);
      return true;
    }
    return done_ = step.norm() < 1e-12 || damping_ > 1e8;
  }

  RefinementState moved_by(const VectorXd& step, const std::vector<Matrix6>& solved) const {
    RefinementState next = x_;
    next.lens = device::changed_lens(x_.lens, step.head<kLens>());
    next.X = moved(x_.X, step.segment<kHandEye>(kLens));
    for (std::size_t i = 0; i < next.places.size(); ++i)
      next.places[i] += step.segment<3>(kPlaces + 3 * static_cast<Eigen::Index>(i));
    for (std::size_t f = 0; f < next.frames.size(); ++f)
      next.frames[f] = moved(x_.frames[f], Vector6(-solved[f] * (blocks_[f].b + blocks_[f].C * step)));
    return next;
  }

  const RefinementProblem& problem_;
  RefinementState x_;
  double rms_px_before_ = 0.0, best_ = 0.0, damping_ = 1e-6;
  int iterations_ = 0;
  bool done_ = false;
  MatrixXd A_;
  VectorXd b_;
  std::vector<RefinementProblem::Frame> blocks_;
};

// With the touches' covariance as it is.
Expected<Estimate<LandmarkRefinement>> refine_once(const rig::CameraCalibration& camera,
                                                   const rig::HandEyeCalibration& hand_eye,
                                                   const std::vector<rig::Landmark>& touched,
                                                   const std::vector<LandmarkFrame>& frames,
                                                   const LandmarkRefinementOptions& options) {
  const auto count = count_sightings(touched, frames);
  if (!count) return tl::unexpected(count.error());
  RefinementProblem problem{camera, hand_eye, touched, frames, options, {}, {}, {}, {}, {}};
  add_information(problem);
  Refinement refinement(problem, options.max_iterations);
  const RefinementState& x = refinement.state();

  Estimate<LandmarkRefinement> result;
  result.value.sightings = *count;
  result.value.rms_px_before = refinement.rms_px_before();
  result.iterations = refinement.iterations();
  result.termination = refinement.converged() ? Termination::converged : Termination::iteration_limit;
  result.covariance = refinement.covariance();
  if (!result.covariance.allFinite() || result.covariance.diagonal().minCoeff() < 0)
    return refused(
        "landmarks: the pictures contradict the touched places (no minimum was found); check which dot is "
        "which");
  auto& value = result.value;
  value.landmarks = touched;
  for (std::size_t i = 0; i < touched.size(); ++i) {
    const auto at = kPlaces + 3 * static_cast<Eigen::Index>(i);
    value.landmarks[i].place.m = x.places[i];
    value.landmarks[i].covariance = result.covariance.block<3, 3>(at, at);
    result.residuals.emplace_back(x.places[i] - touched[i].place.m);
  }
  value.hand_eye = hand_eye;
  if (options.correct_hand_eye) {
    value.hand_eye.X_marker_camera = x.X;
    value.hand_eye.covariance = result.covariance.block<kHandEye, kHandEye>(kLens, kLens);
  }
  value.camera = camera;
  value.camera.model = x.lens;
  if (camera.covariance.size() > 0) value.camera.covariance = result.covariance.topLeftCorner<kLens, kLens>();
  value.rms_px = rms_px(problem, x, &value.inliers);
  return result;
}

// What the places' moves away from the touches say of the hand, given that it misses by `sd`.
rig::TouchNoise touch_noise_from(const Estimate<LandmarkRefinement>& refined,
                                 const std::vector<rig::Landmark>& touched, double sd) {
  double moves = 0.0, expected = 0.0;
  for (std::size_t i = 0; i < touched.size(); ++i) {
    const Matrix3 P = inverse_symmetric(touched[i].covariance + kLeastVariance * Matrix3::Identity());
    const auto at = kPlaces + 3 * static_cast<Eigen::Index>(i);
    const Matrix3 Q = refined.covariance.block<3, 3>(at, at);
    moves += (P * refined.residuals[i]).squaredNorm();
    expected += std::max(0.0, (P - P * Q * P).trace());
  }
  const double s2 = sd * sd;
  if (!(s2 * expected > 0.0)) return {};
  return {std::sqrt(s2 * moves / expected), s2 * expected};
}

}  // namespace

Expected<Estimate<LandmarkRefinement>> refine_landmarks(const rig::CameraCalibration& camera,
                                                        const rig::HandEyeCalibration& hand_eye,
                                                        const std::vector<rig::Landmark>& touched,
                                                        const std::vector<LandmarkFrame>& frames,
                                                        const LandmarkRefinementOptions& options) {
  auto refined = refine_once(camera, hand_eye, touched, frames, options);
  if (!refined || !options.touch) return refined;
  std::vector<rig::Landmark> weighed = touched;
  rig::TouchNoise hand = *options.touch;
  for (int round = 0; round < kTouchRounds; ++round) {
    const rig::TouchNoise next =
        calibration::noise::pooled(*options.touch, touch_noise_from(*refined, weighed, hand.sd));
    const bool settled = std::abs(next.sd - hand.sd) < kSettled * hand.sd;
    const double more = next.sd * next.sd - hand.sd * hand.sd;
    hand = next;
    if (settled) break;
    for (auto& landmark : weighed) landmark.covariance.diagonal().array() += more;
    refined = refine_once(camera, hand_eye, weighed, frames, options);
    if (!refined) return refined;
  }
  refined->value.touch = hand;
  return refined;
}

}  // namespace palpate::vision
