#include "palpate/vision/landmark_refinement.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <optional>

#include "palpate/math/linear_algebra.h"
#include "palpate/math/pose_step.h"

namespace palpate::vision {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double kLeastVariance = 1e-18;  // m^2: a perfect touch stays invertible
constexpr int kTouchRounds = 6;
constexpr double kSettled = 0.03;  // of the hand's sd: far less than what so few touches tell
constexpr Eigen::Index kLens = device::kLensParameters, kHandEye = 6;
constexpr Eigen::Index kPlaces = kLens + kHandEye;  // of all unknowns that frames share, the landmarks' first

struct RefinementState {
  device::CameraModel lens;
  Pose<CameraMarker, CameraOptical> X;
  std::vector<Pose<World, CameraMarker>> frames;
  std::vector<Vector3> places;
};

device::LensParameters lens_difference(const device::CameraModel& a, const device::CameraModel& b) {
  device::LensParameters d;
  d.head<4>() << a.fx - b.fx, a.fy - b.fy, a.cx - b.cx, a.cy - b.cy;
  for (std::size_t i = 0; i < a.distortion.size(); ++i)
    d[4 + static_cast<Eigen::Index>(i)] = a.distortion[i] - b.distortion[i];
  return d;
}

// Of all unknowns: what frames share (lens, hand-eye, landmarks), and each frame's six, which are eliminated so
// that a step solves for what is shared.
struct RefinementEquations {
  struct Frame {
    Matrix6 A;
    Vector6 b;
    MatrixXd C;  // 6 x shared
  };
  struct Step {
    VectorXd shared;
    std::vector<Vector6> frames;
  };

  MatrixXd A;
  VectorXd b;
  std::vector<Frame> frames;

  void set_zero(Eigen::Index shared, std::size_t frame_count) {
    A = MatrixXd::Zero(shared, shared);
    b = VectorXd::Zero(shared);
    frames.assign(frame_count, {Matrix6::Zero(), Vector6::Zero(), MatrixXd::Zero(6, shared)});
  }

  MatrixXd shared_information() const {
    MatrixXd S = A;
    for (const auto& frame : frames)
      S.noalias() -= frame.C.transpose() * solve_symmetric_columns(frame.A, frame.C);
    return S;
  }

  DampedStep<Step> solve(double damping) const {
    MatrixXd S = A;
    S.diagonal() *= 1.0 + damping;
    VectorXd g = b;
    std::vector<Matrix6> solved;
    for (const auto& frame : frames) {
      Matrix6 D = frame.A;
      D.diagonal() *= 1.0 + damping;
      solved.push_back(inverse_symmetric(D));
      const MatrixXd CD = frame.C.transpose() * solved.back();
      S.noalias() -= CD * frame.C;
      g.noalias() -= CD * frame.b;
    }
    DampedStep<Step> result{{VectorXd(g.size()), {}}, {}};
    Step& step = result.step;
    StepModel& model = result.model;
    model = solve_damped(S, g, 0.0, step.shared);
    if (!std::isfinite(model.predicted)) return result;
    double squared = 0.0;
    model.predicted = 0.0;
    const auto count = [&](const auto& diagonal, const auto& part, const auto& gradient) {
      const double length2 = part.dot(diagonal.cwiseProduct(part));
      squared += length2;
      model.predicted += damping * length2 - part.dot(gradient);
    };
    count(A.diagonal(), step.shared, b);
    for (std::size_t f = 0; f < frames.size(); ++f) {
      step.frames.push_back(-solved[f] * (frames[f].b + frames[f].C * step.shared));
      count(frames[f].A.diagonal(), step.frames.back(), frames[f].b);
    }
    model.length = std::sqrt(squared);
    return result;
  }
};

struct RefinementProblem {
  const rig::CameraCalibration& camera;
  const rig::HandEyeCalibration& hand_eye;
  const std::vector<rig::Landmark>& touched;
  const std::vector<LandmarkFrame>& frames;
  const LandmarkRefinementOptions& options;
  Eigen::Matrix<double, kLens, kLens> lens_information;
  PosePrior<CameraMarker, CameraOptical> known_hand_eye;
  std::vector<PosePrior<World, CameraMarker>> known_frames;
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

  double evaluate(const RefinementState& x, RefinementEquations* equations) const {
    const auto shared = kPlaces + 3 * static_cast<Eigen::Index>(touched.size());
    if (equations) equations->set_zero(shared, frames.size());
    double cost = evaluate_known(x, equations);
    for (std::size_t f = 0; f < frames.size(); ++f)
      for (const auto& seen : frames[f].sightings) {
        const auto m = miss(x, f, seen);
        if (!m) continue;
        const Robust robust = huber(m->squared(), options.huber);
        cost += robust.loss;
        if (equations) add_sighting(x, f, seen, *m, robust.weight, *equations);
      }
    return cost;
  }

  // What is known beforehand of lens, hand-eye, landmarks and frames.
  double evaluate_known(const RefinementState& x, RefinementEquations* equations) const {
    const device::LensParameters el = lens_difference(x.lens, camera.model);
    double cost = el.dot(lens_information * el) + known_hand_eye.cost(x.X);
    for (std::size_t i = 0; i < touched.size(); ++i) {
      const Vector3 e = x.places[i] - touched[i].place.m;
      cost += e.dot(place_information[i] * e);
    }
    for (std::size_t f = 0; f < frames.size(); ++f) cost += known_frames[f].cost(x.frames[f]);
    if (!equations) return cost;
    auto& [A, b, blocks] = *equations;
    A.topLeftCorner<kLens, kLens>() = lens_information;
    b.head<kLens>() = lens_information * el;
    known_hand_eye.add(x.X, A.block<kHandEye, kHandEye>(kLens, kLens), b.segment<kHandEye>(kLens));
    for (std::size_t i = 0; i < touched.size(); ++i) {
      const auto at = kPlaces + 3 * static_cast<Eigen::Index>(i);
      A.block<3, 3>(at, at) = place_information[i];
      b.segment<3>(at) = place_information[i] * (x.places[i] - touched[i].place.m);
    }
    for (std::size_t f = 0; f < frames.size(); ++f)
      known_frames[f].add(x.frames[f], blocks[f].A, blocks[f].b);
    for (Eigen::Index k = 0; k < kPlaces; ++k) {
      if (!held[static_cast<std::size_t>(k)]) continue;
      A.row(k).setZero();
      A.col(k).setZero();
      b[k] = 0.0;
    }
    return cost;
  }

  void add_sighting(const RefinementState& x, std::size_t f, const Sighting& seen, const Miss& m,
                    double weight, RefinementEquations& equations) const {
    const Eigen::Matrix2d W = weight * m.weight;
    const Eigen::Matrix<double, 2, 3> Jm = m.Jp * x.X.matrix().transpose(),
                                      JL = Jm * x.frames[f].matrix().transpose();
    Eigen::Matrix<double, 2, 6> Jf;
    Jf << JL * hat(m.arm_world), -JL;
    Eigen::Matrix<double, 2, kPlaces> Jq;  // lens and hand-eye
    Jq << device::lens_jacobian(x.lens, m.in_camera), Jm * hat(m.arm_marker), -Jm;
    for (Eigen::Index k = 0; k < kPlaces; ++k)
      if (held[static_cast<std::size_t>(k)]) Jq.col(k).setZero();
    const auto at = kPlaces + 3 * static_cast<Eigen::Index>(seen.landmark);
    const Eigen::Matrix<double, 6, 2> JfW = Jf.transpose() * W;
    const Eigen::Matrix<double, kPlaces, 2> JqW = Jq.transpose() * W;
    const Eigen::Matrix<double, 3, 2> JLW = JL.transpose() * W;
    auto& [A, b, blocks] = equations;
    auto& block = blocks[f];
    block.A += JfW * Jf;
    block.b += JfW * m.r;
    block.C.leftCols<kPlaces>() += JfW * Jq;
    block.C.middleCols<3>(at) += JfW * JL;
    A.topLeftCorner<kPlaces, kPlaces>() += JqW * Jq;
    A.block<kPlaces, 3>(0, at) += JqW * JL;
    A.block<3, kPlaces>(at, 0) += JLW * Jq;
    A.block<3, 3>(at, at) += JLW * JL;
    b.head<kPlaces>() += JqW * m.r;
    b.segment<3>(at) += JLW * m.r;
  }

  RefinementState moved_by(const RefinementState& x, const RefinementEquations::Step& step) const {
    RefinementState next = x;
    next.lens = device::changed_lens(x.lens, step.shared.head<kLens>());
    next.X = moved(x.X, step.shared.segment<kHandEye>(kLens));
    for (std::size_t i = 0; i < next.places.size(); ++i)
      next.places[i] += step.shared.segment<3>(kPlaces + 3 * static_cast<Eigen::Index>(i));
    for (std::size_t f = 0; f < next.frames.size(); ++f) next.frames[f] = moved(x.frames[f], step.frames[f]);
    return next;
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
  problem.known_hand_eye = {problem.hand_eye.X_marker_camera, hand_eye_covariance};
  for (const auto& frame : problem.frames)
    problem.known_frames.emplace_back(frame.X_world_marker, frame.covariance);
  for (const auto& landmark : problem.touched)
    problem.place_information.push_back(
        inverse_symmetric(landmark.covariance + kLeastVariance * Matrix3::Identity()));
}

RefinementState start_of(const RefinementProblem& problem) {
  RefinementState x{problem.camera.model, problem.hand_eye.X_marker_camera, {}, {}};
  for (const auto& frame : problem.frames) x.frames.push_back(frame.X_world_marker);
  for (const auto& landmark : problem.touched) x.places.push_back(landmark.place.m);
  return x;
}

// Of what frames share; what is held has none.
MatrixXd shared_covariance(const RefinementProblem& problem, const RefinementState& x) {
  RefinementEquations at;
  problem.evaluate(x, &at);
  return covariance_from_information(at.shared_information());
}

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
  RefinementState x = start_of(problem);

  Estimate<LandmarkRefinement> result;
  result.value.sightings = *count;
  result.value.rms_px_before = rms_px(problem, x, nullptr);
  const auto solved = minimise_with(
      RefinementEquations(), x,
      [&](const RefinementState& at, RefinementEquations* equations) {
        return problem.evaluate(at, equations);
      },
      [&](const RefinementState& at, const RefinementEquations::Step& step) {
        return problem.moved_by(at, step);
      },
      {.most_iterations = options.max_iterations});
  result.iterations = solved.iterations;
  result.termination = solved.converged ? Termination::converged : Termination::iteration_limit;
  result.covariance = shared_covariance(problem, x);
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
