#include "palpate/calibration/hand_eye.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "palpate/calibration/motion_correlation.h"
#include "palpate/calibration/robust_scale.h"
#include "palpate/core/units.h"
#include "palpate/estimation/linear_algebra.h"

namespace palpate {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
constexpr int kUnknowns = 13;  // X rotation 3, X translation 3, Z rotation 3, Z translation 3, delay
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Jacobian = Eigen::Matrix<double, 6, kUnknowns>;

// Cauchy loss c^2 log(1 + d^2 / c^2) of the whitened squared residual d^2, which is about 6 for an honest
// pose: c^2 = 24 keeps 95 % of the efficiency on normal noise and bounds what a blunder can pull.
constexpr double kCauchy = 24.0;
constexpr double kMedianChi2With6 = 5.348;
constexpr double kMedianNorm3 = 1.538;  // median length of a normal 3-vector with unit deviations

// Below this turn about a second axis the camera's place cannot be told from the board's: refused. Four times
// that is asked for by a warning.
const double kLeastSpread = radians_from_degrees(1.5), kGoodSpread = radians_from_degrees(6.0);

void sort_by_time(std::vector<StampedPose>& poses) {
  std::stable_sort(poses.begin(), poses.end(),
                   [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
  poses.erase(std::unique(poses.begin(), poses.end(),
                          [](const auto& a, const auto& b) { return a.time_s == b.time_s; }),
              poses.end());
}

struct HandAt {
  Quaternion R = Quaternion::Identity();
  Vector3 t = Vector3::Zero();
  Vector3 w = Vector3::Zero(), v = Vector3::Zero();  // angular velocity and velocity, World axes
};

bool hand_at(const std::vector<StampedPose>& hand, double time_s, double max_gap_s, HandAt& out) {
  const auto next = std::lower_bound(hand.begin(), hand.end(), time_s,
                                     [](const auto& p, double s) { return p.time_s < s; });
  if (next == hand.end()) return false;
  if (next == hand.begin() && next->time_s > time_s) return false;
  const auto& b = next == hand.begin() ? *(next + 1) : *next;
  const auto& a = next == hand.begin() ? *next : *(next - 1);
  const double gap = b.time_s - a.time_s, s = (time_s - a.time_s) / gap;
  if (gap > max_gap_s) return false;
  const Vector3 turn = so3_log(a.rotation.conjugate() * b.rotation);
  out.R = a.rotation * so3_exp(s * turn);
  out.t = (1 - s) * a.translation + s * b.translation;
  out.w = out.R * turn / gap;
  out.v = (b.translation - a.translation) / gap;
  return true;
}

struct State {
  Quaternion Rx = Quaternion::Identity(), Rz = Quaternion::Identity();
  Vector3 tx = Vector3::Zero(), tz = Vector3::Zero();
  double delay = 0.0;

  State moved(const Unknowns& d) const {
    return {(so3_exp(d.segment<3>(0)) * Rx).normalized(), (so3_exp(d.segment<3>(6)) * Rz).normalized(),
            tx + d.segment<3>(3), tz + d.segment<3>(9), delay + d(12)};
  }
};

Vector6 residual(const State& x, const HandAt& hand, const StampedPose& eye, Jacobian* J) {
  const Quaternion Rp = hand.R * x.Rx, Rq = x.Rz * eye.rotation;
  const Vector3 arm_x = hand.R * x.tx, arm_z = x.Rz * eye.translation;
  const Vector3 d = arm_z + x.tz - arm_x - hand.t;
  const Matrix3 to_camera = Rp.conjugate().toRotationMatrix();
  Vector6 r;
  r.head<3>() = so3_log(Rp.conjugate() * Rq);
  r.tail<3>() = to_camera * d;
  if (J != nullptr) {
    const Matrix3 Rh = hand.R.toRotationMatrix(), turn = so3_left_jacobian_inverse(r.head<3>()) * to_camera;
    const Matrix3 shift = to_camera * hat(d);  // the camera axes, in which d is told, turn with hand and X
    J->block<3, 3>(0, 0) = -turn * Rh;
    J->block<3, 3>(3, 0) = shift * Rh;
    J->block<3, 3>(0, 3).setZero();
    J->block<3, 3>(3, 3) = -to_camera * Rh;
    J->block<3, 3>(0, 6) = turn;
    J->block<3, 3>(3, 6) = -to_camera * hat(arm_z);
    J->block<3, 3>(0, 9).setZero();
    J->block<3, 3>(3, 9) = to_camera;
    J->block<3, 1>(0, 12) = -turn * hand.w;
    J->block<3, 1>(3, 12) = shift * hand.w - to_camera * (hand.v + hand.w.cross(arm_x));
  }
  return r;
}

// One problem: the eye poses that the hand stream encloses at every delay tried.
struct HandEyeProblem {
  const std::vector<StampedPose>& hand;
  std::vector<StampedPose> eye;
  double max_gap_s;
  bool free_delay;
  Matrix6 whiten = Matrix6::Identity();

  // Poses whose moment falls into a gap at this delay do not count; they are few, being at the ends.
  template <typename F>
  void each(const State& x, F&& f) const {
    HandAt at;
    for (std::size_t i = 0; i < eye.size(); ++i)
      if (hand_at(hand, eye[i].time_s + x.delay, max_gap_s, at)) f(i, at);
  }

  // Mean loss, so that delays at which fewer poses count are not favoured.
  double cost(const State& x) const {
    double sum = 0.0;
    int n = 0;
    each(x, [&](std::size_t i, const HandAt& at) {
      sum += kCauchy * std::log1p((whiten * residual(x, at, eye[i], nullptr)).squaredNorm() / kCauchy);
      ++n;
    });
    return n == 0 ? 1e300 : sum / n;
  }

  std::vector<Vector6> residuals(const State& x) const {
    std::vector<Vector6> result;
    each(x, [&](std::size_t i, const HandAt& at) { result.push_back(residual(x, at, eye[i], nullptr)); });
    return result;
  }

  bool solve(State& x, int max_iterations, int& iterations) const {
    double damping = 1e-4, best = cost(x);
    for (int k = 0; k < max_iterations; ++k) {
      ++iterations;
      Normal A = Normal::Zero();
      Unknowns b = Unknowns::Zero();
      int n = 0;
      each(x, [&](std::size_t i, const HandAt& at) {
        Jacobian J;
        const Vector6 r = whiten * residual(x, at, eye[i], &J);
        const Jacobian Jw = whiten * J;
        const double w = 1.0 / (1.0 + r.squaredNorm() / kCauchy);
        A.noalias() += w * Jw.transpose() * Jw;
        b.noalias() += w * Jw.transpose() * r;
        ++n;
      });
      A /= std::max(n, 1), b /= std::max(n, 1);
      if (!free_delay) A.row(12).setZero(), A.col(12).setZero(), A(12, 12) = 1.0, b(12) = 0.0;
      bool accepted = false;
      while (damping < 1e10) {
        Normal damped = A;
        damped.diagonal() *= 1.0 + damping;
        const Unknowns step = -solve_symmetric(damped, b);
        const State next = x.moved(step);
        const double c = cost(next);
        if (c <= best) {
          const bool done = step.norm() < 1e-11 || best - c < 1e-13 * best;
          x = next, best = c, damping = std::max(0.1 * damping, 1e-12), accepted = true;
          if (done) return true;
          break;
        }
        if (step.norm() < 1e-11) return true;
        damping *= 10.0;
      }
      if (!accepted) return true;
    }
    return false;
  }
};

// Rotation of X over relative rotations of distant pairs, weighted down where a pair does not agree.
Quaternion start_rotation(const std::vector<HandAt>& hand, const std::vector<StampedPose>& eye) {
  std::vector<Vector3> a, b;
  const std::size_t n = eye.size();
  for (std::size_t divisor : {2, 3, 5, 8, 13}) {
    const std::size_t stride = std::max<std::size_t>(1, n / divisor);
    for (std::size_t i = 0; i + stride < n; ++i) {
      const Vector3 h = so3_log(hand[i].R.conjugate() * hand[i + stride].R);
      const Vector3 e = so3_log(eye[i].rotation.conjugate() * eye[i + stride].rotation);
      // near half a turn the axis' sign is arbitrary; tiny turns say nothing
      if (std::max(h.norm(), e.norm()) > 2.8 || h.norm() < 0.02) continue;
      a.push_back(h), b.push_back(e);
    }
  }
  Quaternion R = Quaternion::Identity();
  std::vector<double> weight;
  std::vector<double> misfit;
  for (std::size_t i = 0; i < a.size(); ++i) misfit.push_back(std::abs(a[i].norm() - b[i].norm()));
  for (int round = 0; round < 15; ++round) {
    const double scale = std::max(2.0 * median(misfit), 1e-9);
    Matrix3 M = Matrix3::Zero();
    for (std::size_t i = 0; i < a.size(); ++i)
      M += a[i] * b[i].transpose() / (1.0 + std::pow(misfit[i] / scale, 2));
    R = Quaternion(nearest_rotation(M).rotation);
    for (std::size_t i = 0; i < a.size(); ++i) misfit[i] = (a[i] - R * b[i]).norm();
  }
  return R;
}

// Z's rotation as a weighted mean of quaternions (Markley 2007), then both translations linearly; blunders
// weighted down.
State start_state(const std::vector<HandAt>& hand, const std::vector<StampedPose>& eye, const Quaternion& Rx,
                  double delay) {
  State x;
  x.Rx = Rx, x.delay = delay;
  std::vector<double> misfit(eye.size(), 0.0);
  for (int round = 0; round < 10; ++round) {
    const double scale = std::max(2.0 * median(misfit), 1e-9);
    Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
    for (std::size_t i = 0; i < eye.size(); ++i) {
      const Eigen::Vector4d q = (hand[i].R * Rx * eye[i].rotation.conjugate()).coeffs();
      M += q * q.transpose() / (1.0 + std::pow(misfit[i] / scale, 2));
    }
    x.Rz.coeffs() = symmetric_eigen(M).vectors.col(3);
    for (std::size_t i = 0; i < eye.size(); ++i)
      misfit[i] = angle_between(hand[i].R * Rx, x.Rz * eye[i].rotation);
  }
  std::fill(misfit.begin(), misfit.end(), 0.0);
  for (int round = 0; round < 15; ++round) {
    const double scale = std::max(2.0 * median(misfit), 1e-9);
    Matrix6 A = Matrix6::Zero();
    Vector6 b = Vector6::Zero();
    for (std::size_t i = 0; i < eye.size(); ++i) {
      Eigen::Matrix<double, 3, 6> J;
      J << hand[i].R.toRotationMatrix(), -Matrix3::Identity();
      const Vector3 d = x.Rz * eye[i].translation - hand[i].t;
      const double w = 1.0 / (1.0 + std::pow(misfit[i] / scale, 2));
      A += w * J.transpose() * J, b += w * J.transpose() * d;
    }
    const Vector6 t = solve_symmetric(A, b);
    x.tx = t.head<3>(), x.tz = t.tail<3>();
    for (std::size_t i = 0; i < eye.size(); ++i)
      misfit[i] = (hand[i].R * x.tx + hand[i].t - x.Rz * eye[i].translation - x.tz).norm();
  }
  return x;
}

// Inverse square root of the residuals' robust scatter, scaled so that the middle residual counts as honest.
Matrix6 whitening(const std::vector<Vector6>& residuals, const Matrix6* before) {
  std::vector<double> turn, shift, squared;
  for (const auto& r : residuals) turn.push_back(r.head<3>().norm()), shift.push_back(r.tail<3>().norm());
  Matrix6 scatter = Matrix6::Zero();
  if (before == nullptr) {
    scatter.diagonal().head<3>().setConstant(std::pow(median(turn) / kMedianNorm3, 2));
    scatter.diagonal().tail<3>().setConstant(std::pow(median(shift) / kMedianNorm3, 2));
  } else {
    double sum = 0.0;
    for (const auto& r : residuals) {
      const double w = 1.0 / (1.0 + (*before * r).squaredNorm() / kCauchy);
      scatter += w * r * r.transpose();
      sum += w;
    }
    scatter /= std::max(sum, 1e-300);
  }
  // A floor far below any device's noise: perfect data must not make the scatter singular.
  scatter.diagonal().array() += 1e-16;
  const auto eigen = symmetric_eigen(scatter);
  Matrix6 W = eigen.vectors * eigen.values.cwiseMax(1e-17).cwiseSqrt().cwiseInverse().asDiagonal() *
              eigen.vectors.transpose();
  for (const auto& r : residuals) squared.push_back((W * r).squaredNorm());
  const double middle = median(squared);
  return middle > 1e-6 ? Matrix6(W * std::sqrt(kMedianChi2With6 / middle)) : W;
}

std::vector<HandAt> enclosed(const std::vector<StampedPose>& hand, const std::vector<StampedPose>& eye,
                             double delay, double max_gap_s, std::vector<StampedPose>& kept) {
  std::vector<HandAt> at;
  kept.clear();
  for (const auto& e : eye) {
    HandAt h;
    if (!hand_at(hand, e.time_s + delay, max_gap_s, h)) continue;
    at.push_back(h);
    kept.push_back(e);
  }
  return at;
}

// rms turn about the three main axes of the motion, largest first.
Vector3 turn_spread(const std::vector<HandAt>& hand) {
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  for (const auto& h : hand) M += h.R.coeffs() * h.R.coeffs().transpose();
  Quaternion mean;
  mean.coeffs() = symmetric_eigen(M).vectors.col(3);
  Matrix3 scatter = Matrix3::Zero();
  for (const auto& h : hand) {
    const Vector3 w = so3_log(mean.conjugate() * h.R);
    scatter += w * w.transpose();
  }
  const Vector3 values = symmetric_eigenvalues(scatter / static_cast<double>(hand.size()));
  return values.cwiseMax(0.0).cwiseSqrt().reverse();
}

struct Start {
  State state;
  double quality =
      1e300;  // log of median rotation residual times median translation residual: needs no scale
};

Start start_at(const std::vector<StampedPose>& hand, const std::vector<StampedPose>& eye, double delay,
               double gap, bool free_delay) {
  std::vector<StampedPose> some, kept;
  const std::size_t step = std::max<std::size_t>(1, eye.size() / 300);  // 300 poses find the basin
  for (std::size_t i = 0; i < eye.size(); i += step) some.push_back(eye[i]);
  const auto at = enclosed(hand, some, delay, gap, kept);
  Start start;
  if (kept.size() < 8) return start;
  start.state = start_state(at, kept, start_rotation(at, kept), delay);
  HandEyeProblem problem{hand, kept, gap, free_delay};
  problem.whiten = whitening(problem.residuals(start.state), nullptr);
  int iterations = 0;
  problem.solve(start.state, 25, iterations);
  std::vector<double> turn, shift;
  for (const auto& r : problem.residuals(start.state))
    turn.push_back(r.head<3>().norm()), shift.push_back(r.tail<3>().norm());
  if (turn.size() >= 8) start.quality = std::log(median(turn) + 1e-12) + std::log(median(shift) + 1e-12);
  return start;
}

// Sandwich covariance of the estimate; tells how long residuals stay alike, and how much the stretches
// disagree.
Normal covariance_of(const HandEyeProblem& problem, const State& x, double& correlation_time_s,
                     double& stretch_inflation, double& condition) {
  Normal A = Normal::Zero();
  std::vector<Unknowns> scores;
  std::vector<double> times;
  problem.each(x, [&](std::size_t i, const HandAt& at) {
    Jacobian J;
    const Vector6 r = problem.whiten * residual(x, at, problem.eye[i], &J);
    if (!problem.free_delay) J.col(12).setZero();
    const Jacobian Jw = problem.whiten * J;
    const double w = 1.0 / (1.0 + r.squaredNorm() / kCauchy);
    const Unknowns g = Jw.transpose() * r;
    A += w * Jw.transpose() * Jw -
         (2.0 * w * w / kCauchy) * g * g.transpose();  // second derivative of the loss
    scores.push_back(w * g);
    times.push_back(problem.eye[i].time_s);
  });
  if (!problem.free_delay) A(12, 12) = 1.0;
  const Unknowns scale = A.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Normal scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const auto eigen = symmetric_eigen(scaled);
  const Unknowns values = eigen.values;
  condition = values(0) <= 0 ? 1e300 : std::sqrt(values(12) / values(0));
  const Normal inverse = scale.asDiagonal() * eigen.vectors *
                         values.cwiseMax(1e-14 * values(12)).cwiseInverse().asDiagonal() *
                         eigen.vectors.transpose() * scale.asDiagonal();
  for (auto& g : scores) g = inverse * g;  // influence of each pose on the unknowns
  Normal sum = Normal::Zero();
  for (const auto& g : scores) sum += g * g.transpose();
  // Correlation time: the influences, in units of their own scatter, until neighbours agree no more.
  const Unknowns unit = sum.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const std::size_t n = scores.size(), most = n / 8;
  std::size_t length = 0;
  while (length < most) {
    double rho = 0.0;
    for (std::size_t i = 0; i + length + 1 < n; ++i)
      rho += unit.cwiseProduct(scores[i]).dot(unit.cwiseProduct(scores[i + length + 1]));
    ++length;
    if (rho / (problem.free_delay ? 13.0 : 12.0) < 0.1) break;
  }
  correlation_time_s = n > 1 && length > 1 ? static_cast<double>(length) * (times.back() - times.front()) /
                                                 static_cast<double>(n - 1)
                                           : 0.0;
  const std::size_t reach = length > 1 ? std::min(2 * length, n / 4) : 0;
  for (std::size_t lag = 1; lag <= reach; ++lag) {
    const double bartlett = 1.0 - static_cast<double>(lag) / static_cast<double>(reach + 1);
    for (std::size_t i = 0; i + lag < n; ++i) {
      const Normal product = scores[i] * scores[i + lag].transpose();
      sum += bartlett * (product + product.transpose());
    }
  }
  // Errors that last longer than that (a board seen from one side, a lens wrong in one corner) show as
  // disagreement between eight stretches of the recording; the whole covariance grows by as much as they
  // disagree too much.
  constexpr std::size_t kStretches = 8;
  if (n >= 20 * kStretches) {
    Unknowns between = Unknowns::Zero();
    for (std::size_t k = 0; k < kStretches; ++k) {
      Unknowns stretch = Unknowns::Zero();
      for (std::size_t i = k * n / kStretches; i < (k + 1) * n / kStretches; ++i) stretch += scores[i];
      between += stretch.cwiseAbs2();
    }
    const int free = problem.free_delay ? kUnknowns : kUnknowns - 1;
    const Unknowns ratio =
        between.cwiseQuotient(sum.diagonal().cwiseMax(1e-300)) * kStretches / (kStretches - 1.0);
    stretch_inflation = std::sqrt(std::max(1.0, ratio.head(free).mean()));
    sum *= stretch_inflation * stretch_inflation;
  }
  return sum * (6.0 * static_cast<double>(n) / std::max(6.0 * static_cast<double>(n) - kUnknowns, 1.0));
}

void add_warnings(HandEyeSolution& s, const Normal& covariance, double inlier_share,
                  const std::vector<Start>& starts) {
  auto& w = s.warnings;
  if (s.second_axis_spread < kGoodSpread)
    w.push_back(
        fmt::format("the rotation axes are nearly parallel (rms {:.1f} deg about the second axis); turn "
                    "about all three axes",
                    degrees_from_radians(s.second_axis_spread)));
  if (s.rotation_range < radians_from_degrees(20.0))
    w.push_back(fmt::format("the hand turned by {:.0f} deg in all; 40 deg and more give a better result",
                            degrees_from_radians(s.rotation_range)));
  const double place = std::sqrt(covariance.diagonal().segment<3>(3).maxCoeff());
  if (place > 0.005)
    w.push_back(
        fmt::format("the camera's place is known to {:.1f} mm only; record longer, turn more", 1e3 * place));
  if (inlier_share < 0.7)
    w.push_back(
        fmt::format("{:.0f} % of the poses do not fit the rest; look for blunders of the board detection",
                    100 * (1 - inlier_share)));
  // exp(0.2): residuals 10 % larger each in rotation and translation
  for (std::size_t i = 1; i < starts.size(); ++i)
    if (starts[i].quality < starts[0].quality + 0.2 &&
        std::abs(starts[i].state.delay - starts[0].state.delay) > 0.05) {
      w.push_back(fmt::format("a delay of {:.3f} s fits almost as well as {:.3f} s; move less regularly",
                              starts[i].state.delay, starts[0].state.delay));
      break;
    }
}

}  // namespace

Expected<Estimate<HandEyeSolution>> calibrate_hand_eye(std::vector<StampedPose> hand,
                                                       std::vector<StampedPose> eye,
                                                       const HandEyeOptions& options) {
  sort_by_time(hand);
  sort_by_time(eye);
  if (hand.size() < 10 || eye.size() < 10)
    return refused("hand-eye: {} hand and {} eye poses at different times, at least 10 each are needed",
                   hand.size(), eye.size());

  std::vector<Start> starts;
  if (options.estimate_delay) {
    const auto candidates = delay_candidates(hand, eye);
    if (candidates.empty() || candidates.front().correlation < 0.2)
      return refused(
          "hand-eye: the streams never turn alike (best correlation {:.2f}, at least 0.20 is needed); do "
          "they belong "
          "together, and did the camera turn?",
          candidates.empty() ? 0.0 : candidates.front().correlation);
    for (const auto& c : candidates)
      if (c.score > 0.5 * candidates.front().score)
        starts.push_back(start_at(hand, eye, c.delay_s, options.max_hand_gap_s, true));
  } else {
    starts.push_back(start_at(hand, eye, options.delay_s, options.max_hand_gap_s, false));
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const auto& a, const auto& b) { return a.quality < b.quality; });
  State x = starts.front().state;

  HandEyeProblem problem{hand, {}, options.max_hand_gap_s, options.estimate_delay};
  const auto at = enclosed(hand, eye, starts.front().quality < 1e300 ? x.delay : options.delay_s,
                           options.max_hand_gap_s, problem.eye);
  if (at.size() < 10)
    return refused(
        "hand-eye: {} eye poses lie between hand poses, at least 10 are needed (hand {:.3f} to {:.3f} s, eye "
        "{:.3f} to "
        "{:.3f} s); where the clocks differ, use --estimate-delay",
        at.size(), hand.front().time_s, hand.back().time_s, eye.front().time_s, eye.back().time_s);
  const Vector3 spread = turn_spread(at);
  if (spread(1) < kLeastSpread)
    return refused(
        "hand-eye: the hand turned by rms {:.2f}, {:.2f}, {:.2f} deg about its main axes; at least {:.1f} "
        "deg about a "
        "second axis are needed to see where the camera sits, turn about all axes",
        degrees_from_radians(spread(0)), degrees_from_radians(spread(1)), degrees_from_radians(spread(2)),
        degrees_from_radians(kLeastSpread));

  Estimate<HandEyeSolution> result;
  problem.whiten = whitening(problem.residuals(x), nullptr);
  bool converged = problem.solve(x, 100, result.iterations);
  for (int round = 0; round < 4; ++round) {  // the scatter settles to three digits in three rounds
    problem.whiten = whitening(problem.residuals(x), &problem.whiten);
    converged = problem.solve(x, 100, result.iterations);
  }
  result.termination = converged ? Termination::converged : Termination::iteration_limit;

  auto& s = result.value;
  s.X_marker_camera = {x.Rx, x.tx};
  s.X_world_board = {x.Rz, x.tz};
  s.delay_s = x.delay;
  s.second_axis_spread = spread(1);
  const Normal covariance =
      covariance_of(problem, x, s.correlation_time_s, s.stretch_inflation, result.condition);
  result.covariance = covariance;
  s.delay_std_s = std::sqrt(covariance(12, 12));
  const double place = std::sqrt(covariance.diagonal().segment<3>(3).maxCoeff());
  if (!(result.condition < 1e6) || !(place < 0.05))
    return refused(
        "hand-eye: the motion does not show where the camera sits (standard deviation {:.0f} mm, condition "
        "{:.1g}); turn "
        "more, and about all axes",
        1e3 * place, result.condition);

  std::vector<double> turn, shift;
  double sum = 0.0;
  int good = 0;
  for (const auto& r : problem.residuals(x)) {
    turn.push_back(r.head<3>().norm());
    shift.push_back(r.tail<3>().norm());
    result.residuals.emplace_back(r.tail<3>());
    result.inlier.push_back((problem.whiten * r).squaredNorm() < kCauchy);
    if (result.inlier.back()) sum += r.tail<3>().squaredNorm(), ++good;
  }
  s.pairs = static_cast<int>(turn.size());
  s.rotation_residual_median = median(turn);
  s.translation_residual_median = median(shift);
  s.translation_rms = std::sqrt(sum / std::max(3 * good, 1));
  for (std::size_t i = 0; i < at.size(); i += std::max<std::size_t>(1, at.size() / 200))
    for (std::size_t j = 0; j < i; j += std::max<std::size_t>(1, at.size() / 200))
      s.rotation_range = std::max(s.rotation_range, angle_between(at[i].R, at[j].R));
  add_warnings(s, covariance, static_cast<double>(good) / std::max(s.pairs, 1), starts);
  return result;
}

}  // namespace palpate
