#include "palpate/calibration/internal/rig_misfit.h"

#include "palpate/calibration/noise/touch_noise.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr double kErrorStep = 1e-2;         // of a deviation, for derivatives
constexpr double kArmUnstated = 3e-5;       // m: encoder steps and what else an arm's model leaves, per axis
constexpr double kLeastOfVariance = 1e-12;  // of the largest variance: devices without noise stay invertible

// W with W'W = C^-1.
Eigen::MatrixXd whitener_of(const Eigen::MatrixXd& C) {
  const auto eigen = math::symmetric_eigen(C);
  const double least = kLeastOfVariance * std::max(eigen.values.maxCoeff(), 1e-300);
  return eigen.values.cwiseMax(least).cwiseSqrt().cwiseInverse().asDiagonal() * eigen.vectors.transpose();
}

// Pixels by the marker's rotation and shift.
Eigen::MatrixXd pixels_by_marker(const RigState& state, const HeadFrame& frame) {
  constexpr double kStep = 1e-6;  // rad, m
  return derivative(6, kStep, [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
    RigState at = state;
    at.head_field += step;
    Eigen::VectorXd pixels(2 * static_cast<Eigen::Index>(frame.dots.size()));
    Eigen::Index row = 0;
    for (const auto& dot : frame.dots) {
      pixels.segment<2>(row) =
          at.pixel(frame, at.landmarks[dot.landmark]).value_or(device::Pixel(device::Pixel::Zero()));
      row += 2;
    }
    return pixels;
  });
}

}  // namespace

RigMisfit::RigMisfit(const rig::Rig& rig, const RigObservations& observed, const VerificationOptions& options)
    : observed_(observed),
      state_(state_of(rig)),
      pixel_variance_(options.pixel_sd * options.pixel_sd),
      root_(error_root(rig, options)) {
  rest_then_ = rig.arm->rest_readings;
  if (rig.delays) delay_then_ = rig.delays->tracker_after_arm_s;
  const rig::TouchNoise hand =
      options.touch.freedoms > 0.0 ? options.touch : noise::touch_noise_of(rig.surfaces);
  const auto begin = [this](Rows& rows) { rows.first = rows_; };
  const auto end = [this](Rows& rows) { rows.count = rows_ - rows.first; };
  begin(rest_);
  const double rest_sd =
      rig::rest_tolerance(rig.arm->model) / 3.0;  // a hand puts the arm to rest within the tolerance
  if (observed.rest)
    add(rest_sd * rest_sd * Eigen::MatrixXd::Identity(observed.rest->size(), observed.rest->size()));
  end(rest_), begin(held_);
  for (const auto& held : observed.held) add(held_covariance(held, options));
  end(held_), begin(touched_);
  for (const auto& touched : observed.touched)
    add(touched.covariance + hand.sd * hand.sd * Matrix3::Identity());
  end(touched_), begin(seen_);
  add_frames();
  end(seen_), begin(delay_);
  if (observed.tracker_delay_s)
    add(Eigen::MatrixXd::Constant(1, 1, observed.tracker_delay_std_s * observed.tracker_delay_std_s));
  end(delay_);
  A_ = derivative(root_.cols(), kErrorStep,
                  [this](const Eigen::VectorXd& u) -> Eigen::VectorXd { return differences(with(u)); });
  inverse_ = math::inverse_symmetric(math::gram(A_) + Eigen::MatrixXd::Identity(A_.cols(), A_.cols()));
}

void RigMisfit::add(const Eigen::MatrixXd& covariance) {
  blocks_.push_back({covariance, whitener_of(covariance)});
  rows_ += covariance.rows();
}

Matrix3 RigMisfit::held_covariance(const HeldStylus& held, const VerificationOptions& options) const {
  const Vector3 lever = held.X_world_marker.rotation * state_.tip;
  Eigen::Matrix<double, 3, 6> J;
  J << -hat(lever), Matrix3::Identity();
  Matrix3 C = J * held.covariance * J.transpose() + held.systematic;
  // An error that changes over its reach turns a marker by its size over that.
  const double turn = std::sqrt(held.systematic.trace() / 3.0) / options.field_reach;
  C += turn * turn * hat(lever) * hat(lever).transpose();
  return C + kArmUnstated * kArmUnstated * Matrix3::Identity();
}

Eigen::MatrixXd RigMisfit::dots_covariance(const HeadFrame& frame) const {
  const auto rows = 2 * static_cast<Eigen::Index>(frame.dots.size());
  Eigen::MatrixXd C = pixel_variance_ * Eigen::MatrixXd::Identity(rows, rows);
  Eigen::Index row = 0;
  for (const auto& dot : frame.dots) C.block<2, 2>(row, row) += dot.covariance, row += 2;
  return C;
}

void RigMisfit::add_frames() {
  for (const auto& frame : observed_.frames) {
    if (frame.dots.empty()) continue;
    const Eigen::MatrixXd J = pixels_by_marker(state_, frame);
    add(J * frame.covariance * J.transpose() + dots_covariance(frame));
  }
}

RigMisfit::MarkerStep RigMisfit::marker_step(const HeadFrame& frame, const RigState& state) const {
  if (frame.dots.empty()) return {Vector6::Zero(), frame.covariance};
  const Eigen::MatrixXd J = pixels_by_marker(state, frame);
  Eigen::VectorXd r(J.rows());
  Eigen::Index row = 0;
  for (const auto& dot : frame.dots) {
    r.segment<2>(row) = dot.centre - state.pixel(frame, state.landmarks[dot.landmark]).value_or(dot.centre);
    row += 2;
  }
  const Eigen::MatrixXd M = frame.covariance;
  const Eigen::MatrixXd gain =
      math::solve_symmetric_columns(J * M * J.transpose() + dots_covariance(frame), J * M);
  return {Vector6(gain.transpose() * r), Matrix6(M - gain.transpose() * J * M)};
}

Eigen::VectorXd RigMisfit::raw(const RigState& state) const {
  Eigen::VectorXd r(rows_);
  Eigen::Index row = 0;
  const auto put = [&](const Eigen::VectorXd& part) {
    r.segment(row, part.size()) = part;
    row += part.size();
  };
  if (observed_.rest) put(*observed_.rest - (rest_then_ - state.zero.cwiseQuotient(state.gain)));
  for (const auto& held : observed_.held)
    put((held.X_world_marker * Point<TipMarker>{state.tip}).m - state.tip_at(held.joints).m);
  for (const auto& touched : observed_.touched)
    put((touched.X_world_pointer * Point<Pointer>{state.pointer_tip}).m - state.place(touched).m);
  for (const auto& frame : observed_.frames)
    for (const auto& dot : frame.dots)
      put(dot.centre - state.pixel(frame, state.landmarks[dot.landmark]).value_or(dot.centre));
  if (observed_.tracker_delay_s)
    put(Eigen::VectorXd::Constant(1, *observed_.tracker_delay_s - delay_then_ - state.tracker_delay));
  return r;
}

Eigen::VectorXd RigMisfit::differences(const RigState& state) const {
  const Eigen::VectorXd r = raw(state);
  Eigen::VectorXd e(rows_);
  Eigen::Index row = 0;
  for (const auto& block : blocks_) {
    const Eigen::Index n = block.whitener.rows();
    e.segment(row, n).noalias() = block.whitener * r.segment(row, n);
    row += n;
  }
  return e;
}

Eigen::MatrixXd RigMisfit::product(const Eigen::MatrixXd& J, const Eigen::MatrixXd& e) const {
  return J.transpose() * e - (A_.transpose() * J).transpose() * (inverse_ * (A_.transpose() * e));
}

RigMisfit::Posterior RigMisfit::posterior(const Eigen::MatrixXd& J, const Eigen::VectorXd& e) const {
  Eigen::MatrixXd all(rows_, A_.cols() + J.cols());
  all << A_, J;
  Eigen::MatrixXd H = math::gram(all);
  H.diagonal().head(A_.cols()).array() += 1.0;
  Posterior found;
  found.covariance = math::covariance_from_information(H);
  found.mean = -found.covariance * (all.transpose() * e);
  return found;
}

Eigen::VectorXd RigMisfit::remaining(const Eigen::MatrixXd& J, const Eigen::VectorXd& e) const {
  const Eigen::VectorXd mean = posterior(J, e).mean;
  return e + A_ * mean.head(A_.cols()) + J * mean.tail(J.cols());
}

Eigen::MatrixXd RigMisfit::spread(Eigen::Index from, Eigen::Index count) const {
  Eigen::MatrixXd devices = Eigen::MatrixXd::Zero(count, count);
  Eigen::Index row = 0;
  for (const auto& block : blocks_) {
    const Eigen::Index n = block.covariance.rows();
    if (row >= from && row < from + count) devices.block(row - from, row - from, n, n) = block.covariance;
    row += n;
  }
  const Eigen::MatrixXd D = derivative(
      root_.cols(), kErrorStep,
      [&](const Eigen::VectorXd& u) -> Eigen::VectorXd { return raw(with(u)).segment(from, count); });
  return devices + D * D.transpose();
}

}  // namespace palpate::calibration
