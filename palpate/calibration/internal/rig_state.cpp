#include "palpate/calibration/internal/rig_state.h"

#include <cmath>

#include "palpate/math/linear_algebra.h"
#include "palpate/math/pose_step.h"

namespace palpate::calibration {
namespace {

constexpr Eigen::Index kSurfaceErrors = 8;
constexpr double kDegree = 0.0174533;
// A knock's usual size, one sigma, per number: what tells a small change of many numbers from one of few.
constexpr double kUsualTurn = 2.0 * kDegree, kUsualShift = 5e-3, kUsualFocus = 0.03, kUsualPrincipalPx = 5.0,
                 kUsualDelay = 0.01;

// Takes an error vector apart, from its beginning on.
class ErrorReader {
 public:
  explicit ErrorReader(const Eigen::VectorXd& errors) : errors_(errors) {}
  Eigen::VectorXd take(Eigen::Index n) {
    at_ += n;
    return errors_.segment(at_ - n, n);
  }

 private:
  const Eigen::VectorXd& errors_;
  Eigen::Index at_ = 0;
};

template <typename P>
void turn_and_shift(P& pose, const Eigen::VectorXd& e) {
  pose = math::moved(pose, Vector6(e));
}

// The covariance's blocks on one diagonal.
class BlockDiagonal {
 public:
  void add(const Eigen::MatrixXd& block, Eigen::Index size) {
    Eigen::MatrixXd next = Eigen::MatrixXd::Zero(C_.rows() + size, C_.rows() + size);
    next.topLeftCorner(C_.rows(), C_.rows()) = C_;
    if (block.rows() == size) next.bottomRightCorner(size, size) = block;
    C_ = std::move(next);
  }
  const Eigen::MatrixXd& matrix() const { return C_; }

 private:
  Eigen::MatrixXd C_;
};

// About the middle of the arm's reach, or of what moved: a turn about a far origin would be a shift as well.
void carry(const Vector3& about, const Eigen::VectorXd& amount, Vector3& place) {
  place = about + so3_exp(amount.head<3>()) * (place - about) + amount.tail<3>();
}

template <typename P>
void carry_pose(const Vector3& about, const Eigen::VectorXd& amount, P& pose) {
  pose.rotation = (so3_exp(amount.head<3>()) * pose.rotation).normalized();
  carry(about, amount, pose.translation);
}

void carry_room(RigState& state, const Vector3& about, const Eigen::VectorXd& amount) {
  for (auto& surface : state.surfaces) carry_pose(about, amount, surface.X_world_rectangle);
  for (auto& landmark : state.landmarks) carry(about, amount, landmark);
}

Vector3 middle_of_room(const RigState& state) {
  if (state.surfaces.empty()) return state.X_world_base.translation;
  const auto& first = state.surfaces.front();
  return 0.5 * (first.corner(0).m + first.corner(2).m);
}

}  // namespace

Point<World> RigState::tip_at(const Eigen::VectorXd& psi) const {
  return X_world_base * device::arm_tip(model, gain.cwiseProduct(psi) + offset + zero);
}

Point<World> RigState::place(const TouchedPlace& touched) const {
  for (const auto& surface : surfaces)
    if (surface.name == touched.what) return surface.corner(touched.index);
  return {landmarks[static_cast<std::size_t>(touched.index)]};
}

std::optional<device::Pixel> RigState::pixel(const HeadFrame& frame, const Vector3& point) const {
  const auto X_world_marker =
      math::moved(math::moved(frame.X_world_marker, Vector6(-camera_delay * frame.rate)), head_field);
  const Vector3 p = ((X_world_marker * X_marker_camera).inverse() * Point<World>{point}).m;
  if (p.z() < device::kNearestSeen) return std::nullopt;
  return lens.project(p);
}

RigState state_of(const rig::Rig& rig) {
  RigState state;
  state.model = rig.arm->model;
  state.gain = rig.arm->correction.gain;
  state.offset = rig.arm->correction.offset;
  state.zero = Eigen::VectorXd::Zero(state.gain.size());
  state.X_world_base = rig.arm->X_world_base;
  state.tip = rig.arm->tip_in_marker;
  if (rig.pointer_pivot) state.pointer_tip = rig.pointer_pivot->tip_in_marker;
  for (const auto& surface : rig.surfaces) {
    rig::SurfaceCalibration place;
    place.name = surface.name;
    place.X_world_rectangle = surface.X_world_rectangle;
    place.width = surface.width;
    place.height = surface.height;
    state.surfaces.push_back(place);
  }
  state.lens = rig.camera->model;
  state.X_marker_camera = rig.hand_eye->X_marker_camera;
  for (const auto& landmark : rig.landmarks) state.landmarks.push_back(landmark.place.m);
  return state;
}

Eigen::MatrixXd error_root(const rig::Rig& rig, const VerificationOptions& options) {
  BlockDiagonal C;
  const auto arm = static_cast<Eigen::Index>(rig::covariance_order(rig.arm->model).size());
  C.add(rig.arm->covariance, arm);
  C.add(rig.pointer_pivot ? rig.pointer_pivot->covariance : Matrix3(Matrix3::Zero()), 3);
  for (const auto& surface : rig.surfaces) C.add(surface.covariance, kSurfaceErrors);
  const Eigen::MatrixXd registration = rig::registration_covariance(rig);
  C.add(registration, registration.rows());
  Eigen::VectorXd own(8);
  const auto delays = rig.delays.value_or(rig::DelayCalibration{});
  own << std::hypot(delays.camera_std_s, options.delay_sd),
      std::hypot(delays.tracker_std_s, options.delay_sd), Vector3::Constant(options.head_turn_sd),
      Vector3::Constant(options.head_shift_sd);
  C.add(own.cwiseAbs2().asDiagonal(), own.size());
  // Scaled, as the numbers differ by many orders of magnitude; what is held fixed has no column.
  const Eigen::VectorXd sd = C.matrix().diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse = sd.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
  const auto eigen = math::symmetric_eigen(inverse.asDiagonal() * C.matrix() * inverse.asDiagonal());
  constexpr double kRounding = 1e-9;
  Eigen::Index first = 0;
  while (first < eigen.values.size() && eigen.values[first] <= kRounding) ++first;
  const Eigen::Index rank = eigen.values.size() - first;
  return sd.asDiagonal() * eigen.vectors.rightCols(rank) * eigen.values.tail(rank).cwiseSqrt().asDiagonal();
}

RigState with_errors(const RigState& at, const Eigen::VectorXd& errors) {
  RigState state = at;
  ErrorReader e(errors);
  const Eigen::Index joints = state.gain.size();
  state.gain += e.take(joints);
  state.offset += e.take(joints);
  turn_and_shift(state.X_world_base, e.take(6));
  state.tip += e.take(3);
  if (state.model.kind == device::ArmModel::Kind::dh) state.model.tool += e.take(3);
  if (state.model.kind == device::ArmModel::Kind::cartesian)
    state.model.correction.terms += e.take(device::PlaceCorrection::kTerms);
  state.pointer_tip += e.take(3);
  for (auto& surface : state.surfaces) {
    turn_and_shift(surface.X_world_rectangle, e.take(6));
    const Eigen::VectorXd sides = e.take(2);
    surface.width += sides[0];
    surface.height += sides[1];
  }
  state.lens = device::changed_lens(state.lens, device::LensParameters(e.take(device::kLensParameters)));
  turn_and_shift(state.X_marker_camera, e.take(6));
  for (auto& landmark : state.landmarks) landmark += e.take(3);
  state.camera_delay += e.take(1)[0];
  state.tracker_delay += e.take(1)[0];
  state.head_field += e.take(6);
  return state;
}

Eigen::VectorXd change_sizes(Change change, const RigState& state) {
  Eigen::VectorXd sizes;
  switch (change) {
    case Change::camera:
    case Change::base:
    case Change::table:
    case Change::tracker:
      sizes.resize(6);
      sizes << Vector3::Constant(kUsualTurn), Vector3::Constant(kUsualShift);
      return sizes;
    case Change::lens:
      return Vector3(kUsualFocus, kUsualPrincipalPx, kUsualPrincipalPx);
    case Change::encoder_zero:
      return Eigen::VectorXd::Constant(
          state.zero.size(),
          state.model.kind == device::ArmModel::Kind::cartesian ? kUsualShift : kUsualTurn);
    case Change::stylus_marker:
    case Change::pointer:
      return Vector3::Constant(kUsualShift);
    case Change::camera_delay:
    case Change::tracker_delay:
      return Eigen::VectorXd::Constant(1, kUsualDelay);
  }
  return sizes;
}

RigState with_change(const RigState& at, Change change, const Eigen::VectorXd& amount) {
  RigState state = at;
  switch (change) {
    case Change::camera:
      turn_and_shift(state.X_marker_camera, amount);
      break;
    case Change::lens:
      state.lens.fx *= 1.0 + amount[0];
      state.lens.fy *= 1.0 + amount[0];
      state.lens.cx += amount[1];
      state.lens.cy += amount[2];
      break;
    case Change::base:
      turn_and_shift(state.X_world_base, amount);
      break;
    case Change::encoder_zero:
      state.zero += amount;
      break;
    case Change::stylus_marker:
      state.tip += amount;
      break;
    case Change::pointer:
      state.pointer_tip += amount;
      break;
    case Change::table:
      carry_room(state, middle_of_room(state), amount);
      break;
    case Change::tracker: {
      const Vector3 about = middle_of_room(state);
      carry_room(state, about, amount);
      carry_pose(about, amount, state.X_world_base);
      break;
    }
    case Change::camera_delay:
      state.camera_delay += amount[0];
      break;
    case Change::tracker_delay:
      state.tracker_delay += amount[0];
      break;
  }
  return state;
}

}  // namespace palpate::calibration
