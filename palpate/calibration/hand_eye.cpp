#include "palpate/calibration/hand_eye.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/internal/hand_eye_covariance.h"
#include "palpate/calibration/internal/hand_eye_misreading.h"
#include "palpate/calibration/internal/hand_eye_motion.h"
#include "palpate/calibration/internal/hand_eye_problem.h"
#include "palpate/calibration/internal/hand_eye_roles.h"
#include "palpate/calibration/internal/hand_eye_start.h"
#include "palpate/calibration/internal/motion_correlation.h"
#include "palpate/calibration/noise/robust_scale.h"
#include "palpate/core/statistics.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

// Turns need no unit and no place: half of them this far off, and no delay that mends it, the two have not seen the same
// motion.
constexpr double kUnrelated = 0.35;  // rad
// The best of all delays brings also two takes that have nothing to do with each other closer than that.
constexpr double kUnrelatedAtBest = 0.14;  // rad
// Places that do not fit, where the turns do: m; of the eye's way; rad.
constexpr double kFarOff = 0.03, kFarOffShare = 0.15, kTurnsFit = 0.035;
// Below this turn about a second axis not even the sign of the answer means anything: refused. Good is what
// is asked for by warnings.
const double kLeastSpread = radians_from_degrees(0.3), kGoodSpread = radians_from_degrees(6.0);
const double kGoodRange = radians_from_degrees(20.0);
constexpr int kFewestPoses = 4, kFewPoses = 15, kFewDistinct = 10;
constexpr double kPlaceKnown = 0.010, kPlaceUnknown = 0.3;  // m, standard deviation
constexpr double kMethodsAgree = 0.010;                     // m
constexpr double kFarCamera = 10.0, kNearCamera = 0.001;    // m, from its marker
constexpr double kShortTake = 5.0;                          // s
// A delay that was not asked for is told of from so many of its deviations on, and from so much on.
constexpr double kSureDelay = 5.0, kDelayMatters = 0.001;  // s
// Further off it has to fit clearly better as well, by residuals 10 % smaller each in rotation and translation: of
// many delays one fits well by chance.
constexpr double kNearDelay = 0.2, kClearlyBetter = 0.2;  // s; log

// How far the closed forms lie from each other at most, m, over the poses that fit.
double scatter_of_methods(const std::vector<HandAt>& hand, const std::vector<device::StampedPose>& eye,
                          const std::vector<bool>& inlier) {
  std::vector<HandAt> good_hand;
  std::vector<device::StampedPose> good_eye;
  for (std::size_t i = 0; i < std::min({hand.size(), eye.size(), inlier.size()}); ++i)
    if (inlier[i]) good_hand.push_back(hand[i]), good_eye.push_back(eye[i]);
  double most = 0.0;
  const auto forms = hand_eye_closed_forms(good_hand, good_eye);
  for (const auto& a : forms)
    for (const auto& b : forms) most = std::max(most, (a.translation - b.translation).norm());
  return most;
}

// Why so few eye poses lie between hand poses.
std::string why_none_between(const std::vector<device::StampedPose>& hand,
                             const std::vector<device::StampedPose>& eye, const HandEyeOptions& options) {
  const bool apart = !options.estimate_delay && (eye.front().time_s + options.delay_s > hand.back().time_s ||
                                                 eye.back().time_s + options.delay_s < hand.front().time_s);
  const double gap = (hand.back().time_s - hand.front().time_s) /
                     static_cast<double>(std::max<std::size_t>(hand.size(), 2) - 1);
  if (!apart && gap > options.max_hand_gap_s)
    return fmt::format(
        "hand poses are {:.3f} s apart, {:.3f} s are the most: are hand and eye exchanged? The hand's are "
        "the tracker's, which is the faster. Of a marker at rest both have the same times, or none",
        gap, options.max_hand_gap_s);
  return options.estimate_delay ? "check that both are of the same take"
                                : "where the clocks differ, use --estimate-delay";
}

// Where the camera would sit further away than any mount reaches.
std::string unit_hint(const HandEyeSolution& s) {
  const double distance = s.X_marker_camera.translation.norm();
  if (distance <= kFarCamera) return "";
  return fmt::format(
      "the camera would sit {:.0f} m from its marker; check the unit in the headers (_mm or _m)", distance);
}

void add_warnings(HandEyeSolution& s, const HandEyeNormal& covariance, const HandEyeMotion& motion,
                  double inlier_share, double eye_seconds, const std::vector<HandEyeStart>& starts) {
  auto& w = s.warnings;
  if (eye_seconds < kShortTake)
    w.push_back(
        fmt::format("{:.1f} s of eye poses are little to find a delay by: another stretch of the hand's "
                    "motion may fit as well; record 20 s and more",
                    eye_seconds));
  if (s.X_marker_camera.translation.norm() < kNearCamera)
    w.push_back(fmt::format(
        "the camera would sit only {:.2f} mm from its marker; check the unit in the headers (_mm or _m)",
        1e3 * s.X_marker_camera.translation.norm()));
  if (const auto hint = unit_hint(s); !hint.empty()) w.push_back(hint);
  if (s.second_axis_spread < kGoodSpread)
    w.push_back(
        fmt::format("the rotation axes are nearly parallel (rms {:.1f} deg about the second axis); turn "
                    "about all three axes",
                    degrees_from_radians(s.second_axis_spread)));
  if (s.rotation_range < kGoodRange)
    w.push_back(fmt::format("the hand turned by {:.0f} deg in all; 40 deg and more give a better result",
                            degrees_from_radians(s.rotation_range)));
  if (s.pairs < kFewPoses)
    w.push_back(fmt::format("{} poses are few; {} and more, turned differently, let errors average out",
                            s.pairs, kFewPoses));
  else if (motion.distinct < kFewDistinct)
    w.push_back(
        fmt::format("only {} of the poses differ by more than 2 deg; turn further between them, {} and more "
                    "different ones are wanted",
                    motion.distinct, kFewDistinct));
  const Matrix3 place = covariance.block<3, 3>(3, 3);
  const auto axes = symmetric_eigen(place);
  const double worst = std::sqrt(std::max(0.0, axes.values[2]));
  if (worst > kPlaceKnown) {
    const Vector3 along = axes.vectors.col(2);
    w.push_back(
        fmt::format("the camera's place is known to {:.0f} mm only along ({:.2f}, {:.2f}, {:.2f}) of the "
                    "marker; record longer, turn more",
                    1e3 * worst, along.x(), along.y(), along.z()));
  }
  // Metres apart, one of them has no answer at all, and its number means nothing.
  if (s.method_scatter > std::max(kMethodsAgree, 3.0 * worst))
    w.push_back(fmt::format(
        "closed-form methods differ by {} on these poses: the motion hardly shows the camera's place, "
        "or the poses carry errors that no method allows for",
        s.method_scatter > 1.0 ? "more than a metre" : fmt::format("{:.0f} mm", 1e3 * s.method_scatter)));
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

// Where the search begins, the best first; of several delays where it is to be found.
Expected<std::vector<HandEyeStart>> find_starts(const std::vector<device::StampedPose>& hand,
                                                const std::vector<device::StampedPose>& eye,
                                                const HandEyeOptions& options) {
  std::vector<HandEyeStart> starts;
  if (options.estimate_delay) {
    const auto candidates = delay_candidates(hand, eye);
    if (candidates.empty() || candidates.front().correlation < 0.2)
      return refused(
          "hand-eye: the streams never turn alike (best correlation {:.2f}, at least 0.20 is needed); do "
          "they belong together, and did the camera turn?",
          candidates.empty() ? 0.0 : candidates.front().correlation);
    for (const auto& c : candidates)
      if (c.score > 0.5 * candidates.front().score)
        starts.push_back(hand_eye_start(hand, eye, c.delay_s, options.max_hand_gap_s, true));
  } else {
    starts.push_back(hand_eye_start(hand, eye, options.delay_s, options.max_hand_gap_s, false));
  }
  std::stable_sort(starts.begin(), starts.end(),
                   [](const auto& a, const auto& b) { return a.quality < b.quality; });
  return starts;
}

// Which of the quaternions seem to be told in another order than their columns' names say, in words; else empty. How fast the
// streams turn is the same in any order, and so are the delays to begin from.
std::string doubt_of_orders(const std::vector<device::StampedPose>& hand,
                            const std::vector<device::StampedPose>& eye,
                            const std::vector<HandEyeStart>& starts, const HandEyeStart& round,
                            const HandEyeOptions& options) {
  if (is_good(starts.front())) return "";
  HandEyeStart best;
  std::string best_whose;
  bool best_scalar_first = true;
  const auto consider = [&](const auto& hands, const auto& eyes, const char* whose, bool scalar_first) {
    for (const auto& start : starts) {
      const auto other =
          hand_eye_start(hands, eyes, start.state.delay, options.max_hand_gap_s, options.estimate_delay);
      if (other.quality >= best.quality) continue;
      best = other;
      best_whose = whose;
      best_scalar_first = scalar_first;
    }
  };
  for (const bool scalar_first : {true, false}) {
    const auto other_hand = reordered(hand, scalar_first), other_eye = reordered(eye, scalar_first);
    consider(hand, other_eye, "the eye's", scalar_first);
    consider(other_hand, eye, "the hand's", scalar_first);
    consider(other_hand, other_eye, "both", scalar_first);
  }
  return doubt_of_order(starts.front(), round, best, best_whose, best_scalar_first);
}

// Refused where the streams are not what they are said to be and more motion would not help; else the starts.
Expected<std::vector<HandEyeStart>> find_sound_starts(const std::vector<device::StampedPose>& hand,
                                                      const std::vector<device::StampedPose>& eye,
                                                      const HandEyeOptions& options) {
  auto starts = find_starts(hand, eye, options);
  const auto turned = find_starts(hand, device::inverted(eye), options);
  const HandEyeStart round = turned ? turned->front() : HandEyeStart{};
  if (starts)
    if (const auto doubt = doubt_of_orders(hand, eye, *starts, round, options); !doubt.empty())
      return refused("{}", doubt);
  if (const auto doubt = doubt_of_direction(starts ? starts->front() : HandEyeStart{}, round); !doubt.empty())
    return refused("{}", doubt);
  if (!starts || !(starts->front().quality < 1e300)) return starts;
  const auto doubt = doubt_of_unit(length_ratio(hand, eye, starts->front().state, options.max_hand_gap_s));
  if (!doubt.empty()) return refused("{}", doubt);
  return starts;
}

// Like HandEyeStart::quality.
double log_of_residuals(const HandEyeSolution& s) {
  return std::log(s.rotation_residual_median + 1e-12) + std::log(s.translation_residual_median + 1e-12);
}

// What is said where the streams fit better at another delay than the one that was used as it is.
std::string doubt_of_delay(const HandEyeSolution& used, const std::vector<device::StampedPose>& hand,
                           const std::vector<device::StampedPose>& eye, const HandEyeOptions& options) {
  if (options.estimate_delay || !options.doubt_delay) return "";
  HandEyeOptions free = options;
  free.estimate_delay = true;
  const auto found = calibrate_hand_eye(hand, eye, free);
  if (!found) return "";
  const HandEyeSolution& other = found->value;
  const double off = std::abs(other.delay_s - used.delay_s);
  if (off < std::max(kDelayMatters, kSureDelay * other.delay_std_s)) return "";
  const double better = log_of_residuals(used) - log_of_residuals(other);
  if (better < (off > kNearDelay ? kClearlyBetter : 0.0)) return "";
  return fmt::format(
      "the clocks seem to differ: with a delay of {:.4f} +- {:.4f} s in place of {:.4f} s the residuals are "
      "{:.3f} deg and {:.3f} mm; use --estimate-delay",
      other.delay_s, other.delay_std_s, used.delay_s, degrees_from_radians(other.rotation_residual_median),
      mm_from_metres(other.translation_residual_median));
}

void solve_in_turns(HandEyeProblem& problem, HandEyeState& x, Estimate<HandEyeSolution>& result) {
  problem.whiten = hand_eye_whitening(problem.residuals(x), nullptr);
  LeastSquaresResult solved = problem.solve(x, 100);
  result.iterations += solved.iterations;
  // Scatter and answer in turn until both stand still: the same answer then from any start and any row order.
  for (int round = 0; round < 60; ++round) {
    const HandEyeState before = x;
    problem.whiten = hand_eye_whitening(problem.residuals(x), &problem.whiten);
    solved = problem.solve(x, 100);
    result.iterations += solved.iterations;
    if ((x.tx - before.tx).norm() < 1e-11 && angle_between(x.Rx, before.Rx) < 1e-11) break;
  }
  result.termination = solved.converged ? Termination::converged : Termination::iteration_limit;
}

// Of each pair; the share of those that count.
double judge_residuals(const HandEyeProblem& problem, const HandEyeState& x,
                       Estimate<HandEyeSolution>& result) {
  auto& s = result.value;
  std::vector<double> turn, shift;
  double sum = 0.0;
  int good = 0;
  for (const auto& r : problem.residuals(x)) {
    turn.push_back(r.head<3>().norm());
    shift.push_back(r.tail<3>().norm());
    result.residuals.emplace_back(r.tail<3>());
    result.inlier.push_back((problem.whiten * r).squaredNorm() < kHandEyeCauchy);
    if (result.inlier.back()) sum += r.tail<3>().squaredNorm(), ++good;
  }
  s.pairs = static_cast<int>(turn.size());
  s.rotation_residual_median = median(turn);
  s.translation_residual_median = median(shift);
  s.translation_rms = std::sqrt(sum / std::max(3 * good, 1));
  return static_cast<double>(good) / std::max(s.pairs, 1);
}

// Rms distance of the places from their middle, m.
double extent(const std::vector<device::StampedPose>& poses) {
  Vector3 middle = Vector3::Zero();
  for (const auto& pose : poses) middle += pose.translation / static_cast<double>(poses.size());
  double squares = 0.0;
  for (const auto& pose : poses) squares += (pose.translation - middle).squaredNorm();
  return std::sqrt(squares / static_cast<double>(poses.size()));
}

}  // namespace

Expected<Estimate<HandEyeSolution>> calibrate_hand_eye(std::vector<device::StampedPose> hand,
                                                       std::vector<device::StampedPose> eye,
                                                       const HandEyeOptions& options) {
  sort_by_time(hand);
  sort_by_time(eye);
  const std::size_t stray = drop_stray_times(hand) + drop_stray_times(eye);
  const std::size_t least = options.estimate_delay ? 10 : kFewestPoses;
  if (hand.size() < least || eye.size() < least)
    return refused(
        "hand-eye: {} hand and {} eye poses at different times, at least {} each are needed; record more",
        hand.size(), eye.size(), least);

  const auto starts = find_sound_starts(hand, eye, options);
  if (!starts) return tl::unexpected(starts.error());
  HandEyeState x = starts->front().state;

  HandEyeProblem problem{hand, {}, options.max_hand_gap_s, options.estimate_delay};
  const auto at = enclosed(hand, eye, starts->front().quality < 1e300 ? x.delay : options.delay_s,
                           options.max_hand_gap_s, problem.eye);
  if (at.size() < least)
    return refused(
        "hand-eye: {} eye poses lie between hand poses, at least {} are needed (hand {:.3f} to {:.3f} s, eye "
        "{:.3f} to {:.3f} s); {}",
        at.size(), least, hand.front().time_s, hand.back().time_s, eye.front().time_s, eye.back().time_s,
        why_none_between(hand, eye, options));
  const HandEyeMotion motion = hand_eye_motion(at);
  const Vector3& spread = motion.spread;
  if (spread(1) < kLeastSpread)
    return refused(
        "hand-eye: the hand turned by rms {:.2f}, {:.2f}, {:.2f} deg about its main axes; at least {:.1f} "
        "deg about a second axis are needed to see where the camera sits, turn about all axes",
        degrees_from_radians(spread(0)), degrees_from_radians(spread(1)), degrees_from_radians(spread(2)),
        degrees_from_radians(kLeastSpread));

  Estimate<HandEyeSolution> result;
  solve_in_turns(problem, x, result);

  auto& s = result.value;
  s.X_marker_camera = {x.Rx, x.tx};
  s.X_world_board = {x.Rz, x.tz};
  s.delay_s = x.delay;
  s.second_axis_spread = spread(1);
  s.rotation_range = motion.range;
  const auto known = hand_eye_covariance(problem, x);
  const HandEyeNormal& covariance = known.total;
  result.covariance = covariance;
  result.condition = known.condition;
  s.correlation_time_s = known.correlation_time_s;
  s.grown_by = known.grown_by;
  s.error_length = known.field_length;
  s.delay_std_s = std::sqrt(covariance(12, 12));
  const double good = judge_residuals(problem, x, result);
  std::string delay_doubt = doubt_of_delay(s, hand, eye, options);
  if (options.doubt_places && delay_doubt.empty() && s.rotation_residual_median < kTurnsFit &&
      s.translation_residual_median > std::max(kFarOff, kFarOffShare * extent(problem.eye)))
    return refused(
        "hand-eye: the turns fit within {:.2f} deg, the places only within {:.0f} mm; check the columns of "
        "both files: the order and signs of x, y and z, the unit, and which number of the quaternion comes "
        "first (qw)",
        degrees_from_radians(s.rotation_residual_median), 1e3 * s.translation_residual_median);
  const double place = std::sqrt(covariance.diagonal().segment<3>(3).maxCoeff());
  if (!(result.condition < 1e7) || !(place < kPlaceUnknown))
    return refused(
        "hand-eye: the motion does not show where the camera sits (standard deviation {:.0f} mm, condition "
        "{:.1g}); {}",
        1e3 * place, result.condition, unit_hint(s).empty() ? "turn more, and about all axes" : unit_hint(s));

  if (auto doubt = doubt_of_roles(hand, eye); !doubt.empty()) s.warnings.push_back(std::move(doubt));
  if (!delay_doubt.empty())
    s.warnings.push_back(std::move(delay_doubt));
  else if (s.rotation_residual_median > (options.estimate_delay ? kUnrelatedAtBest : kUnrelated))
    return refused(
        "hand-eye: no place of the camera suits both recordings (median residual {:.0f} deg, {:.0f} mm); "
        "check that hand and eye are of the same take{}",
        degrees_from_radians(s.rotation_residual_median), 1e3 * s.translation_residual_median,
        options.estimate_delay ? "" : " and on the same clock (--estimate-delay)");
  const auto now = enclosed(problem.hand, problem.eye, x.delay, options.max_hand_gap_s, eye);
  s.method_scatter = scatter_of_methods(now, eye, result.inlier);
  if (stray > 0)
    s.warnings.push_back(counted(stray, "pose") + " left out: the time lies far beyond that of all others");
  add_warnings(s, covariance, motion, good,
               options.estimate_delay ? eye.back().time_s - eye.front().time_s : kShortTake, *starts);
  return result;
}

}  // namespace palpate::calibration
