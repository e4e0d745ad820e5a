#include "palpate/calibration/force_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/calibration/internal/force_fit.h"
#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

// Below this share of the strongest joint's gain a joint counts as one without power.
constexpr double kNoPower = 0.15;
// m/N: at 0.5 N half of a tenth of a millimetre, about a step of the encoders.
constexpr double kBlocked = 1e-4;
// Deviations: of what is told in the arm's disfavour (twice in a thousand by chance), and of what is told in its favour
// (one in twenty).
constexpr double kSure = 3.0, kLikely = 1.645;

constexpr const char* kAxes[] = {"x", "y", "z"};

std::string name_of(bool of_joints, int i) {
  return of_joints ? fmt::format("joint {}", i + 1) : fmt::format("axis {}", kAxes[i]);
}

std::vector<int> counted_up(std::size_t n) {
  std::vector<int> order(n);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

// Every pair exchanged, and of three also the two turns.
std::vector<std::vector<int>> other_orders(std::size_t n) {
  std::vector<std::vector<int>> orders;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      orders.push_back(counted_up(n));
      std::swap(orders.back()[i], orders.back()[j]);
    }
  if (n == 3) orders.insert(orders.end(), {{1, 2, 0}, {2, 0, 1}});
  return orders;
}

double chi2_limit(int freedoms) {  // exceeded by chance once in 10^5 (Wilson, Hilferty 1931)
  constexpr double kDeviations = 4.265;
  const double k = freedoms, h = 2.0 / (9.0 * k);
  return k * std::pow(1.0 - h + kDeviations * std::sqrt(h), 3.0);
}

// The mean response of each pose, and how responses to the same force scatter.
struct Measured {
  std::vector<PoseCompliance> poses;
  double scatter = 0.0;  // m/N
  double size = 0.0;     // m/N, rms of a column's length
};

Expected<Measured> measure(std::span<const ForcePose> poses, const ForceCheckSettings& settings) {
  Measured measured;
  double squares = 0.0;
  int freedoms = 0;
  std::vector<Matrix3> weights;
  for (const auto& pose : poses) {
    Matrix3 directions = Matrix3::Zero(), moved = Matrix3::Zero();
    for (const auto& ramp : pose.ramps) {
      if (!ramp.compliance.allFinite() || std::abs(ramp.direction.norm() - 1.0) > 1e-6)
        return wrong_use("force check: a ramp's response is no number, or its direction has no length of 1");
      directions += ramp.direction * ramp.direction.transpose();
      moved += ramp.compliance * ramp.direction.transpose();
    }
    if (pose.jacobian.cols() != poses.front().jacobian.cols())
      return wrong_use("force check: a pose has {} joints, another one {}", pose.jacobian.cols(),
                       poses.front().jacobian.cols());
    if (pose.jacobian.cols() < 3 || !pose.jacobian.allFinite())
      return wrong_use("force check: a pose has no Jacobian of three joints or more");
    if (symmetric_eigenvalues(directions).minCoeff() < 2.0 - 1e-6)
      return wrong_use("force check: a pose has {} ramps; two or more along each axis are expected",
                       pose.ramps.size());
    const Matrix3 weight = inverse_symmetric(directions);
    const Matrix3 A = moved * weight;
    for (const auto& ramp : pose.ramps) squares += (ramp.compliance - A * ramp.direction).squaredNorm();
    freedoms += 3 * static_cast<int>(pose.ramps.size()) - 9;
    measured.poses.push_back({pose.jacobian, A, Vector3::Zero()});
    measured.size += A.squaredNorm() / 3.0;
    weights.push_back(weight);
  }
  if (poses.empty()) return wrong_use("force check: no pose was tried; one or more are expected");
  measured.scatter = std::sqrt(squares / freedoms);
  measured.size = std::sqrt(measured.size / static_cast<double>(poses.size()));
  const double imperfect = settings.hand_nonlinearity * measured.size;
  for (std::size_t k = 0; k < poses.size(); ++k)
    for (int j = 0; j < 3; ++j)
      measured.poses[k].deviation[j] =
          std::max(std::hypot(measured.scatter * std::sqrt(weights[k](j, j)), imperfect), 1e-12);
  return measured;
}

// What one explanation's gains say.
struct GainFault {
  ForceVerdict verdict = ForceVerdict::agreed;
  int which = -1, other = -1;
  double ratio = 1.0;
};

GainFault judge_gains(const ForceFit& fit, const ForceCheckSettings& settings) {
  const Eigen::VectorXd& g = fit.gains;
  // Beside the strongest: how firm the grip was is the same for all, and says nothing of signs.
  Eigen::Index s = 0;
  const double strongest = g.cwiseAbs().maxCoeff(&s);
  const auto n = static_cast<int>(g.size());
  for (int i = 0; i < n; ++i) {
    const double ratio = g[i] / g[s];
    const double variance =
        fit.covariance(i, i) + ratio * ratio * fit.covariance(s, s) - 2.0 * ratio * fit.covariance(i, s);
    const double sure = kSure * std::sqrt(std::max(variance, 0.0)) / strongest;
    if (g[i] < -kNoPower * strongest && -g[i] > kSure * fit.noise[i])
      return {fit.explanation.of_joints ? ForceVerdict::joint_mirrored : ForceVerdict::axis_mirrored, i};
    if (std::abs(ratio) < kNoPower && std::abs(ratio) + sure < 2.0 * kNoPower)
      return {ForceVerdict::joint_without_power, i};
  }
  for (int i = 0; i < n; ++i)
    if (!(g[i] > kSure * fit.noise[i])) return {ForceVerdict::undetermined, i};
  std::vector<int> by_size = counted_up(static_cast<std::size_t>(n));
  std::sort(by_size.begin(), by_size.end(), [&](int a, int b) { return g[a] < g[b]; });
  const int median = by_size[static_cast<std::size_t>(n / 2)];
  GainFault worst;
  double most = std::log(settings.agreed_ratio);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      if (i == j) continue;
      const double ln = std::log(g[i] / g[j]);
      const double variance = fit.covariance(i, i) / (g[i] * g[i]) + fit.covariance(j, j) / (g[j] * g[j]) -
                              2.0 * fit.covariance(i, j) / (g[i] * g[j]);
      const double deviation = std::sqrt(std::max(variance, 0.0));
      const bool off = std::abs(ln) > kSure * deviation;
      if (settings.states_place && !off) continue;
      if (std::abs(ln) + kLikely * deviation <= most) continue;
      most = std::abs(ln) + kLikely * deviation;
      const bool first =
          std::abs(std::log(std::abs(g[i] / g[median]))) > std::abs(std::log(std::abs(g[j] / g[median])));
      const int odd = first ? i : j, other = first ? j : i;
      worst = {off ? ForceVerdict::ratio_off : ForceVerdict::undetermined, odd, other, g[odd] / g[other]};
    }
  return worst;
}

void put_gains(ForceCheck& check, const ForceFit& fit, const Eigen::Matrix3Xd& jacobian) {
  const auto n = fit.gains.size();
  std::vector<double> sizes(fit.gains.data(), fit.gains.data() + n);
  std::sort(sizes.begin(), sizes.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  const double median = std::abs(sizes[static_cast<std::size_t>(n / 2)]);
  check.joint_gains = fit.gains / median;
  check.covariance = fit.covariance / (median * median);
  const double mean = fit.gains.cwiseAbs().mean();
  Eigen::MatrixXd B(9, n);
  check.map.setZero();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Matrix3 part = felt_map(fit.explanation, jacobian, static_cast<int>(i)) / mean;
    check.map += fit.gains[i] * part;
    B.col(i) = part.transpose().reshaped();  // row by row
  }
  check.map_covariance = B * fit.covariance * B.transpose();
  const Eigen::VectorXd hand = symmetric_eigenvalues(fit.hand);
  check.anisotropy = hand.maxCoeff() / hand.minCoeff();
}

ForceVerdict of_axes(ForceVerdict verdict) {
  if (verdict == ForceVerdict::joint_mirrored) return ForceVerdict::axis_mirrored;
  return verdict == ForceVerdict::joints_exchanged ? ForceVerdict::axes_exchanged : verdict;
}

std::string words_of(const ForceCheck& check, bool of_joints, double ratio) {
  const auto name = [&](int i) { return name_of(of_joints, i); };
  switch (check.verdict) {
    case ForceVerdict::agreed:
      return check.ratios_told ? "forces go where they are commanded"
                               : "forces go the way they are commanded along each axis; whether all axes are "
                                 "equally strong a hand cannot tell of an arm that states its place";
    case ForceVerdict::axis_mirrored:
      return fmt::format(
          "{} is mirrored: the hand is pushed against the commanded force; see to the axes of driver and arm "
          "model",
          name(check.first));
    case ForceVerdict::joint_mirrored:
      return fmt::format(
          "{} is mirrored: its motor turns the other way; see to its wiring, or to the sign of its angle in "
          "driver and arm model",
          name(check.first));
    case ForceVerdict::axes_exchanged:
    case ForceVerdict::joints_exchanged:
      return fmt::format(
          "{} and {} are exchanged: one moves where the other should; see to wiring and order in driver and "
          "arm model",
          name(check.first), name(check.second));
    case ForceVerdict::joint_without_power:
      return fmt::format(
          "{} is without power: it gives less than {:.0f} % of what the others give; see to its motor, cable "
          "and amplifier",
          name(check.first), 100.0 * kNoPower);
    case ForceVerdict::ratio_off:
      return fmt::format(
          "{} gives {:.2f} times what {} gives for the same command; see to the amplifiers and gears of "
          "both, and to the arm model",
          name(check.first), ratio, name(check.second));
    case ForceVerdict::too_little_motion:
      return fmt::format(
          "the tip gave way by {:.3f} mm per newton only: hold the stylus lightly, away from stops and "
          "table; see that the motors have power",
          kMillimetresPerMetre * check.compliance);
    case ForceVerdict::restless_hand:
      return fmt::format(
          "the hand moved by itself: it answered the same force by {:.2f} and, another time, by {:.2f} mm/N; "
          "rest the arm on the table, hold still, and try again",
          kMillimetresPerMetre * std::max(0.0, check.compliance - check.scatter),
          kMillimetresPerMetre * (check.compliance + check.scatter));
    case ForceVerdict::undetermined:
      if (!check.ratios_told)
        return fmt::format(
            "which way {} pushes is not told well enough: hold the stylus lightly and still, try again",
            name(std::max(check.first, 0)));
      return fmt::format(
          "the ratio of the joints' gains is not told well enough ({}): try poses that differ more, and hold "
          "the stylus alike in all of them",
          name(std::max(check.first, 0)));
    case ForceVerdict::unexplained:
      return fmt::format(
          "no single fault explains how the hand gave way (misfit {:.0f}, about {} expected): hold the "
          "stylus alike in all poses, and see to the arm's calibration",
          check.cost, check.freedoms);
  }
  return "";
}

}  // namespace

std::string_view name_of(ForceVerdict verdict) {
  switch (verdict) {
    case ForceVerdict::agreed:
      return "agreed";
    case ForceVerdict::axis_mirrored:
      return "axis mirrored";
    case ForceVerdict::axes_exchanged:
      return "axes exchanged";
    case ForceVerdict::joint_mirrored:
      return "joint mirrored";
    case ForceVerdict::joints_exchanged:
      return "joints exchanged";
    case ForceVerdict::joint_without_power:
      return "joint without power";
    case ForceVerdict::ratio_off:
      return "ratio off";
    case ForceVerdict::too_little_motion:
      return "too little motion";
    case ForceVerdict::restless_hand:
      return "restless hand";
    case ForceVerdict::undetermined:
      return "undetermined";
    case ForceVerdict::unexplained:
      return "unexplained";
  }
  return "unknown";
}

std::optional<RampResponse> ramp_response(const Vector3& direction, std::span<const RampSample> samples) {
  const auto n = static_cast<Eigen::Index>(samples.size());
  if (n < 8) return std::nullopt;
  Eigen::MatrixXd M(n, 4), d(n, 3);
  const double begin = samples.front().time, length = samples.back().time - begin;
  double largest = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& s = samples[static_cast<std::size_t>(i)];
    const auto& before = samples[static_cast<std::size_t>(std::max<Eigen::Index>(i - 1, 0))];
    const auto& after = samples[static_cast<std::size_t>(std::min(i + 1, n - 1))];
    const double dt = after.time - before.time;
    M.row(i) << 1.0, (s.time - begin) / length, s.force, dt > 0.0 ? (after.force - before.force) / dt : 0.0;
    d.row(i) = s.displacement.transpose();
    largest = std::max(largest, std::abs(s.force));
  }
  if (!(largest > 0.0 && length > 0.0) || !M.allFinite() || !d.allFinite()) return std::nullopt;
  const Eigen::MatrixXd found = least_squares_columns(M, d);
  return RampResponse{direction, found.row(2).transpose()};
}

Expected<ForceCheck> check_forces(std::span<const ForcePose> poses, const ForceCheckSettings& settings) {
  const auto measured = measure(poses, settings);
  if (!measured) return tl::unexpected(measured.error());
  const std::size_t n = static_cast<std::size_t>(poses.front().jacobian.cols());
  ForceCheck check;
  check.ratios_told = !settings.states_place;
  check.scatter = measured->scatter;
  check.compliance = measured->size;
  check.joint_gains = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
  check.covariance = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  const auto end = [&](ForceVerdict verdict, const ForceExplanation& what, int first = -1, int second = -1,
                       double ratio = 1.0) {
    check.verdict = settings.states_place ? of_axes(verdict) : verdict;
    check.first = first, check.second = second;
    check.words = words_of(check, what.of_joints && !settings.states_place, ratio);
    return check;
  };
  const ForceExplanation joints{true, counted_up(n)}, axes{false, counted_up(3)};
  if (measured->size < kBlocked) return end(ForceVerdict::too_little_motion, joints);

  const ForceFit as_joints = fit_forces(measured->poses, joints, settings);
  // What such an arm has for joints are its axes.
  const ForceFit as_axes = settings.states_place ? as_joints : fit_forces(measured->poses, axes, settings);
  std::optional<ForceFit> exchanged;
  const auto consider = [&](bool of_joints, std::size_t count) {
    for (const auto& order : other_orders(count)) {
      ForceFit fit = fit_forces(measured->poses, {of_joints, order}, settings);
      if (!exchanged || fit.cost < exchanged->cost) exchanged = std::move(fit);
    }
  };
  consider(true, n);
  if (!settings.states_place) consider(false, 3);
  put_gains(check, as_joints, poses.front().jacobian);
  check.cost = as_joints.cost;
  check.next_cost = exchanged->cost;
  check.freedoms = 9 * static_cast<int>(poses.size()) - static_cast<int>(n);
  const double limit = chi2_limit(check.freedoms);

  const double straight = std::min(as_joints.cost, as_axes.cost);
  if (exchanged->cost + settings.clearly_better < straight && exchanged->cost <= limit) {
    const auto& order = exchanged->explanation.order;
    int first = 0;
    while (order[static_cast<std::size_t>(first)] == first) ++first;
    const auto verdict =
        exchanged->explanation.of_joints ? ForceVerdict::joints_exchanged : ForceVerdict::axes_exchanged;
    return end(verdict, exchanged->explanation, first, order[static_cast<std::size_t>(first)]);
  }
  const ForceFit& told = as_axes.cost + 0.5 * settings.clearly_better < as_joints.cost ? as_axes : as_joints;
  if (told.cost > limit) return end(ForceVerdict::unexplained, joints);
  const GainFault fault = judge_gains(told, settings);
  // Of one ramp's response: with less, it is the poses that tell too little.
  constexpr double kRestless = 0.25;
  if (fault.verdict == ForceVerdict::undetermined && measured->scatter > kRestless * measured->size)
    return end(ForceVerdict::restless_hand, joints);
  if (fault.verdict != ForceVerdict::agreed) {
    return end(fault.verdict, told.explanation, fault.which, fault.other, fault.ratio);
  }
  if (&told != &as_joints) return end(ForceVerdict::unexplained, joints);
  if (exchanged->cost < straight + settings.clearly_better) return end(ForceVerdict::undetermined, joints, 0);
  return end(ForceVerdict::agreed, joints);
}

Expected<WeightGain> gain_of_weight(double weight_n, std::span<const double> rising,
                                    std::span<const double> sinking, const ForceCheckSettings& settings) {
  const std::size_t n = rising.size();
  if (!(weight_n > 0.0) || n < 3 || sinking.size() != n)
    return refused(
        "force check: the weight rose {} times and sank {} times; three times each, or more, are expected", n,
        sinking.size());
  double sum = 0.0, squares = 0.0, friction = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!(rising[i] > 0.0 && sinking[i] > 0.0))
      return refused(
          "force check: the weight rose at {:.3f} N and sank at {:.3f} N; forces upwards are expected: see "
          "that it hangs at the tip, and that nothing else holds it",
          rising[i], sinking[i]);
    const double middle = 0.5 * (rising[i] + sinking[i]);
    sum += weight_n / middle;
    squares += (weight_n / middle) * (weight_n / middle);
    friction += 0.5 * (rising[i] - sinking[i]);
  }
  const auto count = static_cast<double>(n);
  WeightGain found;
  found.gain = sum / count;
  const double variance = std::max(0.0, squares - count * found.gain * found.gain) / (count - 1.0);
  found.deviation = std::sqrt(variance / count);
  found.friction = friction / count * found.gain;
  if (std::abs(std::log(found.gain)) + kLikely * found.deviation / found.gain >
      std::log(settings.agreed_ratio))
    return refused(
        "force check: the weight of {:.3f} N is held by {:.3f} N of commanded force: a gain of {:.2f} +- "
        "{:.2f}; 1 within a factor of {:g} is expected: see to the amplifiers and the arm's model",
        weight_n, weight_n / found.gain, found.gain, found.deviation, settings.agreed_ratio);
  return found;
}

}  // namespace palpate::calibration
