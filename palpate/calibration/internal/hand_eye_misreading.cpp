#include "palpate/calibration/internal/hand_eye_misreading.h"

#include <cmath>

#include "palpate/calibration/noise/robust_scale.h"
#include "palpate/core/statistics.h"
#include "palpate/core/text.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr double kFarBetter = 3.0;  // times smaller residuals, of rotation and of translation
constexpr double kSound = 0.05;     // rad and m, residuals; by larger ones nothing is told
constexpr double kGood = 0.005;     // the same; with smaller ones no other reading is looked for
constexpr double kOtherUnit = 3.0;  // times as long, or as short: no board is printed so much too large
constexpr double kLeftOver = 0.3;
constexpr double kKnownRatio = 0.1;    // of itself; less known, it tells nothing
constexpr std::size_t kFewest = 6;     // poses
constexpr std::size_t kEnough = 1000;  // poses

bool is_sound(const HandEyeStart& start) { return start.quality < 2.0 * std::log(kSound); }

bool fits_far_better(const HandEyeStart& other, const HandEyeStart& start) {
  return start.quality - other.quality > 2.0 * std::log(kFarBetter) && is_sound(other);
}

std::string times_better(const HandEyeStart& other, const HandEyeStart& start) {
  if (!(start.quality < 1e300)) return "only";
  return fmt::format("{:.0f} times better", std::exp(0.5 * std::min(start.quality - other.quality, 20.0)));
}

}  // namespace

bool is_good(const HandEyeStart& start) { return start.quality < 2.0 * std::log(kGood); }

std::string doubt_of_direction(const HandEyeStart& start, const HandEyeStart& round) {
  if (!fits_far_better(round, start)) return "";
  // hand^-1 X = Z eye is hand Z = X eye^-1: with the hand turned round the two transforms change places, and the camera would
  // sit as far from its marker as the board from the tracker.
  const bool eye = round.state.tx.norm() <= round.state.tz.norm();
  return fmt::format(
      "hand-eye: the poses fit {} with {} turned round: they seem to be {}; give {} (palpate convert "
      "--invert)",
      times_better(round, start), eye ? "the eye's" : "the hand's",
      eye ? "the board's in the camera, as OpenCV and ROS tell them" : "the tracker's in the marker",
      eye ? "the camera's in the board" : "the marker's in the tracker");
}

std::vector<device::StampedPose> reordered(std::vector<device::StampedPose> poses, bool told_scalar_first) {
  for (auto& pose : poses) pose.rotation = device::in_other_order(pose.rotation, told_scalar_first);
  return poses;
}

std::string doubt_of_order(const HandEyeStart& start, const HandEyeStart& round, const HandEyeStart& other,
                           std::string_view whose, bool told_scalar_first) {
  if (!fits_far_better(other, start) || !fits_far_better(other, round)) return "";
  return fmt::format(
      "hand-eye: the poses fit {} with the numbers of {} quaternions in another order: read as {}, they "
      "hold {}; correct the header, or the order where there is none",
      times_better(other, start), whose, told_scalar_first ? "qw,qx,qy,qz" : "qx,qy,qz,qw",
      told_scalar_first ? "qx,qy,qz,qw" : "qw,qx,qy,qz");
}

LengthRatio length_ratio(const std::vector<device::StampedPose>& hand,
                         const std::vector<device::StampedPose>& eye, const HandEyeState& at,
                         double max_gap_s) {
  std::vector<device::StampedPose> some, kept;
  const std::size_t step = std::max<std::size_t>(1, eye.size() / kEnough);
  for (std::size_t i = 0; i < eye.size(); i += step) some.push_back(eye[i]);
  const auto hand_at = enclosed(hand, some, at.delay, max_gap_s, kept);
  if (kept.size() < kFewest) return {};
  // R_hand t_X - t_Z - ratio R_Z t_eye = -t_hand, blunders weighted down.
  using Matrix7 = Eigen::Matrix<double, 7, 7>;
  using Vector7 = Eigen::Matrix<double, 7, 1>;
  std::vector<double> misfit(kept.size(), 0.0);
  Vector7 x = Vector7::Zero();
  Matrix7 A;
  for (int round = 0; round < 15; ++round) {
    const double scale = std::max(2.0 * median(misfit), 1e-12);
    A.setZero();
    Vector7 b = Vector7::Zero();
    const auto rows_of = [&](std::size_t i) {
      Eigen::Matrix<double, 3, 7> J;
      J << hand_at[i].R.toRotationMatrix(), -Matrix3::Identity(), -(at.Rz * kept[i].translation);
      return J;
    };
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const auto J = rows_of(i);
      const double w = cauchy_weight(std::pow(misfit[i] / scale, 2), 1.0);
      A += w * J.transpose() * J, b -= w * J.transpose() * hand_at[i].t;
    }
    // In units in which its diagonal is 1: lengths and a ratio of any size.
    const Vector7 size = A.diagonal().cwiseSqrt().cwiseMax(1e-150).cwiseInverse();
    const Matrix7 scaled = size.asDiagonal() * A * size.asDiagonal();
    x = size.asDiagonal() * scaled.completeOrthogonalDecomposition().solve(size.asDiagonal() * b);
    for (std::size_t i = 0; i < kept.size(); ++i) misfit[i] = (rows_of(i) * x + hand_at[i].t).norm();
  }
  const double sd = median(misfit) / noise::kMedianOfChi3;
  const Vector7 size = A.diagonal().cwiseSqrt().cwiseMax(1e-150).cwiseInverse();
  const Matrix7 scaled = size.asDiagonal() * A * size.asDiagonal();
  const auto inverse = scaled.ldlt();
  if (inverse.info() != Eigen::Success || !(inverse.rcond() > 1e-12)) return {};
  const double variance = inverse.solve(Vector7::Unit(6))[6] * size[6] * size[6];
  Vector3 middle = Vector3::Zero();
  for (const auto& pose : kept) middle += pose.translation / static_cast<double>(kept.size());
  double square = 0.0;
  for (const auto& pose : kept) square += (pose.translation - middle).squaredNorm();
  const double told = std::abs(x[6]) * std::sqrt(square / (3.0 * static_cast<double>(kept.size())));
  return {x[6], sd * std::sqrt(std::max(0.0, variance)), told > 0.0 ? sd / told : 1.0};
}

std::string doubt_of_unit(const LengthRatio& found) {
  const double ratio = std::abs(found.ratio);
  if (!(found.std < kKnownRatio * ratio) || !(found.left_over < kLeftOver) ||
      (ratio < kOtherUnit && ratio > 1.0 / kOtherUnit))
    return "";
  return fmt::format(
      "hand-eye: the eye's places fit {:.3g} times as long as they are told (+- {:.1g}): the two files' "
      "lengths are in "
      "different units; check the headers (_mm or _m) of both, and the size of the board's squares",
      ratio, found.std);
}

}  // namespace palpate::calibration
