#include "palpate/vision/pixel_hand_eye.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/hand_eye.h"
#include "palpate/core/statistics.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"
#include "palpate/vision/camera.h"
#include "palpate/vision/internal/pixel_hand_eye_problem.h"

namespace palpate::vision {
namespace {

constexpr std::size_t kFewestViews = 4;
constexpr int kMostRounds = 60;                                               // of noise and state in turn
constexpr double kFreedoms = 5.0;                                             // of the views' t distribution
constexpr double kCornerKnee = 3.0;                                           // deviations
constexpr double kLeastTurn = 1e-6, kLeastPlace = 1e-6, kLeastCorner = 1e-6;  // rad, m, px: exact data
constexpr double kUnlikeScale = 0.005;  // of the squares: what a printer does
constexpr double kUnlikeDelay = 0.001;  // s
constexpr double kSure = 5.0;           // deviations
constexpr double kPlaceKnown = 0.010;   // m, standard deviation
constexpr double kOtherWay = 0.5;       // of the residual, where the hand's poses are turned round

struct Fitted {
  PixelState x;
  PixelNoise noise;
  Eigen::MatrixXd covariance;  // of the 23 unknowns
  double condition = 0.0, squared_px = 0.0;
  std::size_t corners = 0;
  int iterations = 0;
  std::vector<std::size_t> used;
};

// How the noise looks at a state: a step of expectation-maximisation, and the weights.
void renew(const PixelProblem& problem, const PixelState& x, const PixelHandEyeOptions& options,
           PixelNoise& noise) {
  double corner = 0.0, entries = 0.0, turn = 0.0, place = 0.0, views = 0.0;
  PixelProblem::View view;
  const PixelNoise before = noise;
  for (std::size_t i = 0; i < problem.views.size(); ++i) {
    if (!problem.linearise(x, i, view)) continue;
    const auto error = hand_error(view, before.corner_weight[i], before.view_weight[i], before);
    const Eigen::MatrixXd spread = view.G * error.covariance;
    auto& weight = noise.corner_weight[i];
    for (Eigen::Index k = 0; k < weight.size(); ++k) {
      const double squared = error.left.segment<2>(2 * k).squaredNorm();
      corner += before.corner_weight[i][k] *
                (squared + spread.middleRows<2>(2 * k).cwiseProduct(view.G.middleRows<2>(2 * k)).sum());
      weight[k] = huber_weight(std::sqrt(squared), kCornerKnee * before.corner);
    }
    entries += 2.0 * static_cast<double>(weight.size());
    const double squared_turn =
        error.mean.head<3>().squaredNorm() + error.covariance.topLeftCorner<3, 3>().trace();
    const double squared_place =
        error.mean.tail<3>().squaredNorm() + error.covariance.bottomRightCorner<3, 3>().trace();
    turn += before.view_weight[i] * squared_turn;
    place += before.view_weight[i] * squared_place;
    noise.view_weight[i] = (kFreedoms + 6.0) / (kFreedoms + squared_turn / (before.turn * before.turn) +
                                                squared_place / (before.place * before.place));
    ++views;
  }
  const double lens = static_cast<double>(problem.free.segment(kLensAt, device::kLensParameters).count());
  noise.corner = std::max(kLeastCorner, std::sqrt(corner / std::max(1.0, entries - lens)));
  // X, Z and the delay took 13 of the views' six errors each.
  const double freedoms = std::max(6.0, 6.0 * views - 13.0) / (6.0 * views);
  noise.turn = options.turn_sd > 0.0 ? options.turn_sd
                                     : std::max(kLeastTurn, std::sqrt(turn / (3.0 * views * freedoms)));
  noise.place = options.place_sd > 0.0 ? options.place_sd
                                       : std::max(kLeastPlace, std::sqrt(place / (3.0 * views * freedoms)));
}

PixelNoise presumed_noise(const std::vector<BoardView>& views, const PixelHandEyeOptions& options) {
  PixelNoise noise;
  if (options.turn_sd > 0.0) noise.turn = options.turn_sd;
  if (options.place_sd > 0.0) noise.place = options.place_sd;
  for (const auto& view : views)
    noise.corner_weight.push_back(Eigen::VectorXd::Ones(static_cast<Eigen::Index>(view.board.size())));
  noise.view_weight.assign(views.size(), 1.0);
  return noise;
}

// What the views' weights cost: the variance of an estimate by a loss (Huber 1967) over that of the weighted
// equations, in which the weights look like known numbers.
double price_of_weights(const Fitted& fitted) {
  double w = 0.0, squared = 0.0;  // means of the weights, and of the squared weighted errors
  for (const auto i : fitted.used) {
    const double weight = fitted.noise.view_weight[i];
    w += weight;
    squared += weight * weight * ((kFreedoms + 6.0) / weight - kFreedoms) / 6.0;
  }
  const auto n = static_cast<double>(fitted.used.size());
  w /= n, squared /= n;
  const double slope = w - 2.0 * squared / (kFreedoms + 6.0);
  return slope > 0.0 ? std::max(1.0, squared * w / (slope * slope)) : 1.0;
}

Fitted fit(const PixelProblem& problem, const PixelState& start, const PixelHandEyeOptions& options) {
  Fitted fitted{start, presumed_noise(problem.views, options), {}, 0.0, 0.0, 0, 0, {}};
  fitted.iterations = problem.solve(fitted.x, fitted.noise, 50).iterations;
  for (int round = 0; round < kMostRounds; ++round) {
    const auto before = fitted.noise;
    renew(problem, fitted.x, options, fitted.noise);
    fitted.iterations += problem.solve(fitted.x, fitted.noise, 10).iterations;
    const auto stood = [](double a, double b) { return std::abs(a - b) < 1e-4 * b; };
    if (stood(fitted.noise.corner, before.corner) && stood(fitted.noise.turn, before.turn) &&
        stood(fitted.noise.place, before.place))
      break;
  }
  PixelProblem::View view;
  for (std::size_t i = 0; i < problem.views.size(); ++i) {
    if (!problem.linearise(fitted.x, i, view)) continue;
    fitted.used.push_back(i);
    fitted.squared_px += view.r.squaredNorm();
    fitted.corners += problem.views[i].board.size();
  }
  NormalEquations<Eigen::Dynamic> equations(kPixelUnknowns);
  problem.evaluate(fitted.x, fitted.noise, &equations);
  const Eigen::MatrixXd information = static_cast<double>(fitted.used.size()) *
                                      Eigen::MatrixXd(equations.JtJ.selfadjointView<Eigen::Lower>());
  fitted.covariance = price_of_weights(fitted) * covariance_from_information(information);
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < kPixelUnknowns; ++k)
    if (problem.free[k] && information(k, k) > 0.0) free.push_back(k);
  fitted.condition = 1e300;
  if (free.empty()) return fitted;  // a solve that has left all numbers
  const Eigen::MatrixXd of_free = information(free, free);
  const Eigen::VectorXd unit = of_free.diagonal().cwiseSqrt().cwiseInverse();
  const auto values = symmetric_eigenvalues(unit.asDiagonal() * of_free * unit.asDiagonal());
  if (values[0] > 0.0) fitted.condition = std::sqrt(values[values.size() - 1] / values[0]);
  return fitted;
}

// The camera's poses at the board, one for each view that has a sensible one.
std::vector<device::StampedPose> eye_poses(const std::vector<BoardView>& views,
                                           const std::vector<double>& time_s,
                                           const device::CameraModel& lens) {
  std::vector<device::StampedPose> eye;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto found = board_pose(lens, views[i], {.max_rms_px = 20.0});
    if (!found || found->value.ambiguous) continue;
    const auto X_board_camera = found->value.X_camera_board.inverse();
    eye.push_back({time_s[i], X_board_camera.rotation, X_board_camera.translation});
  }
  return eye;
}

// Where poses do not carry a start: the cameras mounted along the marker's axes, and what the solve makes of them.
std::optional<PixelState> best_mount(const PixelProblem& problem, const std::vector<device::StampedPose>& eye,
                                     const PixelState& like, const PixelHandEyeOptions& options) {
  std::optional<PixelState> best;
  double least = 0.0;
  auto noise = presumed_noise(problem.views, options);
  noise.turn = 0.02, noise.place = 0.02;
  for (const auto& first : eye) {
    const auto at = problem.hand_at(first.time_s + like.delay_s);
    if (!at) continue;
    for (int face = 0; face < 6; ++face)
      for (int quarter = 0; quarter < 4; ++quarter) {
        Vector3 axis = Vector3::Zero();
        axis[face / 2] = face % 2 ? -1.0 : 1.0;
        PixelState x = like;
        x.X = {
            rotation_between(Vector3::UnitZ(), axis) * so3_exp({0.0, 0.0, 0.5 * quarter * 3.14159265358979}),
            Vector3::Zero()};
        x.Z = at->pose * x.X * first.as<Board, CameraOptical>().inverse();
        const double cost = problem.solve(x, noise, 30).cost;
        if (std::isfinite(cost) && (!best || cost < least)) best = x, least = cost;
      }
    break;
  }
  return best;
}

std::optional<PixelState> start_of(const PixelProblem& problem, const device::CameraModel& lens,
                                   const PixelHandEyeOptions& options) {
  const auto eye = eye_poses(problem.views, problem.time_s, lens);
  PixelState x;
  x.lens = lens;
  x.delay_s = options.delay_s;
  calibration::HandEyeOptions how{.estimate_delay = options.free_delay,
                                  .delay_s = options.delay_s,
                                  .max_hand_gap_s = problem.max_hand_gap_s,
                                  .doubt_delay = false,  // the pixels themselves are asked
                                  .doubt_places = false};
  auto by_poses = calibration::calibrate_hand_eye(problem.hand, eye, how);
  if (!by_poses && options.free_delay) {
    how.estimate_delay = false;
    by_poses = calibration::calibrate_hand_eye(problem.hand, eye, how);
  }
  if (!by_poses) return best_mount(problem, eye, x, options);
  x.X = by_poses->value.X_marker_camera;
  x.Z = by_poses->value.X_world_board;
  if (how.estimate_delay) x.delay_s = by_poses->value.delay_s;
  return x;
}

double rms_px(const Fitted& fitted) {
  return std::sqrt(fitted.squared_px / static_cast<double>(std::max<std::size_t>(1, fitted.corners)));
}

std::vector<device::StampedPose> turned_round(const std::vector<device::StampedPose>& hand) {
  auto result = hand;
  for (auto& pose : result) {
    const auto inverse = pose.as<World, CameraMarker>().inverse();
    pose.rotation = inverse.rotation;
    pose.translation = inverse.translation;
  }
  return result;
}

// Hand poses that are the tracker's in the marker have a solution, too, with larger residuals.
Expected<void> refuse_other_way(const PixelProblem& problem, const Fitted& fitted,
                                const device::CameraModel& lens, const PixelHandEyeOptions& options) {
  const auto other_hand = turned_round(problem.hand);
  const PixelProblem other_way{other_hand, problem.views, problem.time_s, problem.max_hand_gap_s,
                               problem.free};
  if (const auto other = start_of(other_way, lens, options)) {
    const auto other_fit = fit(other_way, *other, options);
    if (other_fit.used.size() == fitted.used.size() && rms_px(other_fit) < kOtherWay * rms_px(fitted))
      return refused(
          "hand-eye: the hand's poses fit the other way round: residuals of {:.2f} px against {:.2f} px; "
          "poses of the marker in the tracker are expected, these look like the tracker in the marker",
          rms_px(other_fit), rms_px(fitted));
  }
  return {};
}

PixelHandEye answer_of(const PixelProblem& problem, const Fitted& fitted) {
  PixelHandEye answer;
  answer.X_marker_camera = fitted.x.X;
  answer.X_world_board = fitted.x.Z;
  answer.delay_s = fitted.x.delay_s;
  answer.lens = fitted.x.lens;
  answer.rms_px = rms_px(fitted);
  answer.noise_px = fitted.noise.corner;
  answer.turn_sd = fitted.noise.turn, answer.place_sd = fitted.noise.place;
  for (const auto i : fitted.used) answer.views.push_back(problem.views[i].name);
  for (const auto i : fitted.used)
    for (const auto j : fitted.used) {
      const auto a = problem.hand_at(problem.time_s[i] + fitted.x.delay_s),
                 b = problem.hand_at(problem.time_s[j] + fitted.x.delay_s);
      if (a && b)
        answer.rotation_range =
            std::max(answer.rotation_range, angle_between(a->pose.rotation, b->pose.rotation));
    }
  return answer;
}

// Each view's hand error with nothing known of it beforehand.
void add_residuals(const PixelProblem& problem, const Fitted& fitted, PixelHandEye& answer) {
  constexpr double kNothingKnown = 1e-9;
  std::vector<double> turns, places;
  PixelProblem::View view;
  for (const auto i : fitted.used) {
    if (!problem.linearise(fitted.x, i, view)) continue;
    const auto error = hand_error(view, fitted.noise.corner_weight[i], kNothingKnown, fitted.noise);
    turns.push_back(error.mean.head<3>().norm());
    places.push_back(error.mean.tail<3>().norm());
  }
  answer.rotation_residual_median = median(std::move(turns));
  answer.translation_residual_median = median(std::move(places));
}

// What the residuals say of things that were taken as they were told.
void look_for_mistakes(const PixelProblem& problem, const Fitted& fitted, bool has_times,
                       const PixelHandEyeOptions& options, PixelHandEye& answer) {
  PixelProblem wider = problem;
  wider.free[kScaleAt] = true;
  const bool look_for_delay = has_times && !options.free_delay;
  wider.free[kDelayAt] = wider.free[kDelayAt] || look_for_delay;
  const auto found = fit(wider, fitted.x, options);
  answer.board_scale = found.x.scale;
  answer.board_scale_sd = std::sqrt(found.covariance(kScaleAt, kScaleAt));
  if (std::abs(found.x.scale - 1.0) > std::max(kSure * answer.board_scale_sd, kUnlikeScale))
    answer.warnings.push_back(
        fmt::format("the board fits {:.4f} +- {:.4f} times as large as told: check the size of its squares "
                    "(--square-mm), the "
                    "printed board and the unit of the hand's poses",
                    found.x.scale, answer.board_scale_sd));
  if (!look_for_delay) return;
  answer.untold_delay_s = found.x.delay_s - options.delay_s;
  answer.untold_delay_sd = std::sqrt(found.covariance(kDelayAt, kDelayAt));
  if (std::abs(answer.untold_delay_s) > std::max(kSure * answer.untold_delay_sd, kUnlikeDelay))
    answer.warnings.push_back(fmt::format(
        "the residuals follow the motion, as if the clocks differed by {:.4f} +- {:.4f} s; let it be found "
        "(--estimate-delay)",
        found.x.delay_s, answer.untold_delay_sd));
}

void add_warnings(const Fitted& fitted, PixelHandEye& answer) {
  const double worst = std::sqrt(symmetric_eigenvalues(fitted.covariance.block(3, 3, 3, 3)).maxCoeff());
  if (worst > kPlaceKnown)
    answer.warnings.push_back(
        fmt::format("the camera's place in its marker is known to {:.0f} mm only in one direction; take more "
                    "views, turned "
                    "further about different axes",
                    1e3 * worst));
  for (const auto i : fitted.used)
    if (fitted.noise.view_weight[i] < 0.1)
      answer.warnings.push_back(fmt::format(
          "view '{}' and its hand pose do not fit the others; it hardly counts",
          excerpt(answer.views[static_cast<std::size_t>(std::find(fitted.used.begin(), fitted.used.end(), i) -
                                                        fitted.used.begin())])));
}

Expected<void> check(const std::vector<device::StampedPose>& hand, const std::vector<BoardView>& views,
                     const std::vector<double>& view_time_s) {
  if (views.size() < kFewestViews)
    return refused("hand-eye: {} of the board; at least {} are needed", counted(views.size(), "view"),
                   kFewestViews);
  if (view_time_s.empty() && hand.size() != views.size())
    return wrong_use("hand-eye: {} and {}; without times they belong together one by one",
                     counted(hand.size(), "hand pose"), counted(views.size(), "view"));
  for (const auto& view : views)
    if (view.board.size() != view.image.size() || view.board.size() < 4)
      return refused("view '{}': {}, at least 4 are needed", excerpt(view.name),
                     counted(view.board.size(), "corner"));
  return {};
}

}  // namespace

Expected<Estimate<PixelHandEye>> calibrate_hand_eye_pixels(std::vector<device::StampedPose> hand,
                                                           const std::vector<BoardView>& views,
                                                           const std::vector<double>& view_time_s,
                                                           const device::CameraModel& lens,
                                                           const PixelHandEyeOptions& options) {
  if (const auto fine = check(hand, views, view_time_s); !fine) return tl::unexpected(fine.error());
  std::vector<double> time_s = view_time_s;
  const bool has_times = !time_s.empty();
  if (!has_times)
    for (std::size_t i = 0; i < views.size(); ++i)
      hand[i].time_s = static_cast<double>(i), time_s.push_back(hand[i].time_s);
  std::stable_sort(hand.begin(), hand.end(),
                   [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
  hand.erase(std::unique(hand.begin(), hand.end(),
                         [](const auto& a, const auto& b) { return a.time_s == b.time_s; }),
             hand.end());
  PixelProblem problem{hand, views, time_s, has_times ? options.max_hand_gap_s : 1.5, {}};
  problem.free.setConstant(kPixelUnknowns, false);
  problem.free.head(12).setConstant(true);
  problem.free[kDelayAt] = has_times && options.free_delay;
  problem.free.segment(kLensAt, 4 + static_cast<Eigen::Index>(device::coefficient_count(lens.kind)))
      .setConstant(options.free_lens);
  const auto start = start_of(problem, lens, options);
  if (!start)
    return refused(
        "hand-eye: no start is found: in none of the {} views the board's pose and a hand pose are known; "
        "{}",
        views.size(),
        has_times ? fmt::format("do the stamps of both belong together, hand poses at most {:.2f} s apart? "
                                "Poses and pictures taken one by one "
                                "need no stamps",
                                problem.max_hand_gap_s)
                  : "is it this board, and are its squares counted rightly?");
  const auto fitted = fit(problem, *start, options);
  if (fitted.used.size() < kFewestViews)
    return refused("hand-eye: only {} lie between hand poses at most {:.2f} s apart; at least {} are needed",
                   counted(fitted.used.size(), "view"), problem.max_hand_gap_s, kFewestViews);
  if (const auto fine = refuse_other_way(problem, fitted, lens, options); !fine)
    return tl::unexpected(fine.error());
  Estimate<PixelHandEye> estimate;
  auto& answer = estimate.value = answer_of(problem, fitted);
  add_residuals(problem, fitted, answer);
  look_for_mistakes(problem, fitted, has_times, options, answer);
  add_warnings(fitted, answer);
  estimate.covariance = fitted.covariance.topLeftCorner(kScaleAt, kScaleAt);
  estimate.condition = fitted.condition;
  estimate.iterations = fitted.iterations;
  estimate.termination = Termination::converged;
  return estimate;
}

}  // namespace palpate::vision
