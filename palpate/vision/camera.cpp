#include "palpate/vision/camera.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "palpate/calibration/noise/robust_scale.h"
#include "palpate/core/statistics.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/lens_fold.h"
#include "palpate/math/linear_algebra.h"
#include "palpate/math/pose_step.h"
#include "palpate/vision/internal/lens_fit.h"

namespace palpate::vision {
namespace {

struct CvViews {
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> image;
};

// How far a board reaches from its origin, m. The solver's own scale is near 1: it stops early on boards of
// microns.
double board_size(const std::vector<BoardView>& views) {
  double size = 0.0;
  for (const auto& view : views)
    for (const auto& p : view.board) size = std::max(size, p.cwiseAbs().maxCoeff());
  return size;
}

CvViews cv_views(const std::vector<BoardView>& views, const std::vector<bool>& use, double unit) {
  CvViews result;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!use[i]) continue;
    auto& board = result.board.emplace_back();
    auto& image = result.image.emplace_back();
    for (const auto& p : views[i].board) {
      const Vector3 q = p / unit;
      board.emplace_back(static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()));
    }
    for (const auto& p : views[i].image)
      image.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  return result;
}

std::vector<bool> outliers(const std::vector<double>& rms, double deviations) {
  const double centre = median(rms);
  std::vector<double> away;
  for (double r : rms) away.push_back(std::abs(r - centre));
  // 1.4826 makes the median absolute deviation a standard deviation of normal data; the floor keeps a set of
  // nearly equal views from flagging its own scatter.
  const double limit = centre + deviations * std::max(1.4826 * median(away), 0.1 * centre);
  std::vector<bool> flags;
  for (double r : rms) flags.push_back(r > limit);
  return flags;
}

double squared_error(const device::CameraModel& camera, const BoardView& view,
                     const Pose<CameraOptical, Board>& X) {
  double sum = 0.0;
  for (std::size_t j = 0; j < view.board.size(); ++j)
    sum += (camera.project(X.rotation * view.board[j] + X.translation) - view.image[j]).squaredNorm();
  return sum;
}

double rms(const device::CameraModel& camera, const BoardView& view, const Pose<CameraOptical, Board>& X) {
  return std::sqrt(squared_error(camera, view, X) / static_cast<double>(view.board.size()));
}

using LensRoot = Eigen::Matrix<double, device::kLensParameters, device::kLensParameters>;

// A square root of the lens's information after every view's pose is eliminated, per unit pixel variance: R with R' R. By
// orthogonal transformations throughout, as coefficients that are hardly told apart would drown in the rounding of J' J.
LensRoot lens_information_root(const device::CameraModel& camera, const std::vector<BoardView>& views,
                               const std::vector<ViewFit>& fits) {
  LensRoot root = LensRoot::Zero();
  const auto take = [&root](const Eigen::MatrixXd& rows) {
    Eigen::MatrixXd stacked(root.rows() + rows.rows(), root.cols());
    stacked << root, rows;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(stacked);
    root = LensRoot(qr.matrixQR().topRows(root.rows()).triangularView<Eigen::Upper>());
  };
  double farthest = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!fits[i].used) continue;
    farthest = std::max(farthest, farthest_seen(views[i], fits[i].X_camera_board));
    const auto rows = 2 * static_cast<Eigen::Index>(views[i].board.size());
    Eigen::MatrixXd of_lens(rows, root.cols()), of_pose(rows, 6);
    for (Eigen::Index j = 0; 2 * j < rows; ++j) {
      const Vector3 turned = fits[i].X_camera_board.rotation * views[i].board[static_cast<std::size_t>(j)];
      const Vector3 p = turned + fits[i].X_camera_board.translation;
      Eigen::Matrix<double, 2, 3> J;
      device::project(camera, p, J);
      of_pose.middleRows<2>(2 * j) << -J * hat(turned), J;
      of_lens.middleRows<2>(2 * j) = device::lens_jacobian(camera, p);
    }
    // What a change of the pose does not explain.
    const Eigen::HouseholderQR<Eigen::MatrixXd> pose(of_pose);
    of_lens.applyOnTheLeft(pose.householderQ().adjoint());
    take(of_lens.bottomRows(rows - 6));
  }
  take(lens_prior(camera.kind, farthest).cwiseSqrt().asDiagonal().toDenseMatrix());
  return root;
}

// Largest angle between the normals of two boards, rad.
double largest_turn(const std::vector<ViewFit>& views) {
  double largest = 0.0;
  for (const auto& a : views)
    for (const auto& b : views)
      if (a.used && b.used) {
        const Vector3 u = a.X_camera_board.matrix().col(2), v = b.X_camera_board.matrix().col(2);
        largest = std::max(largest, std::atan2(u.cross(v).norm(), u.dot(v)));
      }
  return largest;
}

Expected<void> check(const std::vector<BoardView>& views) {
  for (const auto& view : views) {
    if (view.board.size() != view.image.size())
      return wrong_use("view '{}': {} board corners but {} pixels", view.name, view.board.size(),
                       view.image.size());
    if (view.board.size() < 8)
      return refused("view '{}': {}, at least 8 are needed; remove the view or show the whole board",
                     view.name, counted(view.board.size(), "corner"));
  }
  if (views.size() < 3)
    return refused("{} of the board, at least 3 (better 10 to 20, tilted differently) are needed",
                   counted(views.size(), "view"));
  return {};
}

}  // namespace

std::vector<std::string> CameraSolution::outlier_views() const {
  std::vector<std::string> names;
  for (const auto& view : views)
    if (view.outlier) names.push_back(view.name);
  return names;
}

namespace {

using Boards = std::vector<Pose<CameraOptical, Board>>;

std::vector<BoardView> those_used(const std::vector<BoardView>& views, const std::vector<bool>& use) {
  std::vector<BoardView> used;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (use[i]) used.push_back(views[i]);
  return used;
}

Expected<Boards> solve_wide_lens(const std::vector<BoardView>& views, const std::vector<bool>& use,
                                 device::CameraModel& model) {
  auto fit = fit_fisheye(those_used(views, use), model.width, model.height);
  if (!fit) return tl::unexpected(fit.error());
  model = fit->lens;
  return std::move(fit->boards);
}

// The lens that fits the used views best, put into `model`; the boards' poses in these.
Expected<Boards> solve_lens(const std::vector<BoardView>& views, const std::vector<bool>& use, double unit,
                            const CameraOptions& options, device::CameraModel& model) {
  if (options.lens == device::LensKind::fisheye) return solve_wide_lens(views, use, model);
  cv::Mat K, distortion;
  std::vector<cv::Mat> turns, places;
  const auto data = cv_views(views, use, unit);
  const int flags = options.free_k3 ? 0 : cv::CALIB_FIX_K3;
  try {
    cv::calibrateCamera(data.board, data.image, {model.width, model.height}, K, distortion, turns, places,
                        flags, {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-12});
  } catch (const cv::Exception&) {
    return refused(
        "the views do not carry a camera's lens (no start could be found); tilt the board differently in "
        "each");
  }
  model.fx = K.at<double>(0, 0), model.fy = K.at<double>(1, 1);
  model.cx = K.at<double>(0, 2), model.cy = K.at<double>(1, 2);
  model.kind = device::LensKind::brown;
  model.distortion = {};
  for (std::size_t k = 0; k < model.coefficients().size(); ++k)
    model.distortion[k] = distortion.at<double>(static_cast<int>(k));
  bool finite = std::isfinite(model.fx + model.fy + model.cx + model.cy);
  for (double d : model.distortion) finite = finite && std::isfinite(d);
  if (!finite || model.fx <= 0 || model.fy <= 0)
    return refused(
        "the fit of the lens went astray (fx {:g}, fy {:g}); tilt the board differently in each view",
        model.fx, model.fy);
  const auto vector = [](const cv::Mat& m) {
    return Vector3(m.at<double>(0), m.at<double>(1), m.at<double>(2));
  };
  Boards boards;
  for (std::size_t k = 0; k < turns.size(); ++k)
    boards.push_back({so3_exp(vector(turns[k])), unit * vector(places[k])});
  if (options.lens == device::LensKind::brown) return boards;
  auto fit = fit_rational(those_used(views, use), {model, std::move(boards)});
  if (!fit) return tl::unexpected(fit.error());
  model = fit->lens;
  return std::move(fit->boards);
}

// Where the board was in each view, and how well that fits; a view that was left out gets the pose it has alone.
void judge_views(const std::vector<BoardView>& views, const std::vector<bool>& use, const Boards& boards,
                 CameraSolution& solution) {
  double sum = 0.0;
  std::size_t count = 0, k = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    auto& fit = solution.views[i];
    fit.used = use[i];
    if (use[i]) {
      fit.X_camera_board = boards[k++];
      sum += squared_error(solution.model, views[i], fit.X_camera_board);
      count += views[i].board.size();
    } else if (const auto pose = board_pose(solution.model, views[i], {.max_rms_px = 1e9})) {
      fit.X_camera_board = pose->value.X_camera_board;
    }
    fit.rms_px = rms(solution.model, views[i], fit.X_camera_board);
  }
  solution.rms_px = std::sqrt(sum / static_cast<double>(count));
}

// Marks outliers; whether the lens is to be solved for again without them, in `use`.
bool leave_out_outliers(const CameraOptions& options, CameraSolution& solution, std::vector<bool>& use) {
  std::vector<double> each;
  for (const auto& fit : solution.views) each.push_back(fit.rms_px);
  const auto flagged = outliers(each, options.outlier_deviations);
  std::size_t good = 0;
  for (std::size_t i = 0; i < flagged.size(); ++i) {
    solution.views[i].outlier = flagged[i];
    good += flagged[i] ? 0 : 1;
  }
  if (!options.reject_outlier_views || good == flagged.size() || good < 3) return false;
  for (std::size_t i = 0; i < flagged.size(); ++i) use[i] = !flagged[i];
  return true;
}

// How many of its parameters are estimated.
int free_parameters(const CameraOptions& options) {
  const int all = 4 + static_cast<int>(device::coefficient_count(options.lens));
  return options.lens == device::LensKind::brown && !options.free_k3 ? all - 1 : all;
}

// Covariance and condition of the lens; refused where the views do not fix it.
Expected<void> judge_lens(const std::vector<BoardView>& views, const std::vector<bool>& use,
                          const CameraOptions& options, Estimate<CameraSolution>& result) {
  const auto& solution = result.value;
  double sum = 0.0;
  const int free = free_parameters(options);
  double freedom = -free;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!use[i]) continue;
    sum += squared_error(solution.model, views[i], solution.views[i].X_camera_board);
    freedom += 2.0 * static_cast<double>(views[i].board.size()) - 6.0;
  }
  if (freedom < 1.0)
    return refused("{} views with too few corners for {} lens parameters", views.size(), free);
  const LensRoot root = lens_information_root(solution.model, views, solution.views);
  const Eigen::MatrixXd R = root.leftCols(free);
  const Eigen::VectorXd scale = R.colwise().norm().cwiseMax(1e-150).cwiseInverse();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(R * scale.asDiagonal(), Eigen::ComputeThinV);
  const Eigen::VectorXd& singular = svd.singularValues();
  const double low = singular.minCoeff(), high = singular.maxCoeff();
  // The prior of a rational lens's coefficients leaves none of them without information.
  const bool regular = low > (options.lens == device::LensKind::rational ? 1e-12 : 3e-7) * high;
  result.condition = high / std::max(low, 1e-150);
  result.covariance = Eigen::MatrixXd::Zero(device::kLensParameters, device::kLensParameters);
  if (regular) {
    const Eigen::MatrixXd axes = scale.asDiagonal() * svd.matrixV() * singular.cwiseInverse().asDiagonal();
    result.covariance.topLeftCorner(free, free) = (sum / freedom) * axes * axes.transpose();
  }
  // A focal length known to no better than a tenth is no calibration: boards all parallel, or all in one
  // place.
  const double f_std = result.standard_deviation(0) / solution.model.fx;
  if (!regular || !(f_std < 0.1))
    return refused(
        "the views do not fix the focal length (standard deviation {:.0f} %); tilt the board by 20 to 45 deg "
        "in different directions",
        regular ? 100.0 * f_std : 100.0);
  return {};
}

void add_warnings(double f_std, CameraSolution& solution) {
  for (const auto& name : solution.outlier_views())
    solution.warnings.push_back(
        fmt::format("view '{}' fits far worse than the others; look at it, or leave it out", name));
  if (f_std > 0.01)
    solution.warnings.push_back(
        fmt::format("fx is known to {:.1f} % only; add views with the board tilted more", 100 * f_std));
  // Errors of corners are not white - paper bends, corners shift with the light - and the less the boards are
  // turned against each other, the more of that goes into the lens, unseen by the residuals.
  constexpr double kLeastTurn = 20.0;  // deg; Zhang found the error least near 45
  if (const double turn = degrees_from_radians(largest_turn(solution.views)); turn < kLeastTurn)
    solution.warnings.push_back(
        fmt::format("no two views differ in tilt by more than {:.0f} deg, so fx may be off by more than its "
                    "standard deviation; add views with the board tilted by 20 to 45 deg",
                    turn));
  if (solution.rms_px > 1.0)
    solution.warnings.push_back(fmt::format(
        "rms {:.2f} px is large; 0.1 to 0.5 px is usual, check board and focus{}", solution.rms_px,
        solution.model.kind == device::LensKind::brown ? ", or the lens is wide: --lens-model fisheye" : ""));
  if (device::folds_inside(solution.model))
    solution.warnings.emplace_back(
        "the lens model folds before the image's corners; add views that reach into the corners");
}

}  // namespace

Expected<Estimate<CameraSolution>> calibrate_camera(const std::vector<BoardView>& views, int width,
                                                    int height, const CameraOptions& options) {
  if (const auto ok = check(views); !ok) return tl::unexpected(ok.error());
  if (width < 2 || height < 2) return wrong_use("image size {}x{} px: give the camera's size", width, height);

  Estimate<CameraSolution> result;
  auto& solution = result.value;
  solution.model.width = width, solution.model.height = height;
  for (const auto& view : views) solution.views.push_back({view.name});
  std::vector<bool> use(views.size(), true);
  const double unit = board_size(views);
  if (!(unit > 0.0))
    return wrong_use("all corners of the board are in one place; give the size of its squares");

  for (int round = 0;; ++round) {
    const auto boards = solve_lens(views, use, unit, options, solution.model);
    if (!boards) return tl::unexpected(boards.error());
    judge_views(views, use, *boards, solution);
    if (round > 0 || !leave_out_outliers(options, solution, use)) break;
  }
  if (auto fine = judge_lens(views, use, options, result); !fine) return tl::unexpected(fine.error());
  result.termination = Termination::converged;
  add_warnings(result.standard_deviation(0) / solution.model.fx, solution);
  return result;
}

namespace {

// The pose alone, from X on; returns the sum of squares, px^2, and J^T J.
double refine(const device::CameraModel& camera, const BoardView& view, Pose<CameraOptical, Board>& X,
              Matrix6& normal) {
  const auto evaluate = [&](const Pose<CameraOptical, Board>& at, NormalEquations<6>* equations) {
    double sum = 0.0;
    for (std::size_t j = 0; j < view.board.size(); ++j) {
      const Vector3 turned = at.rotation * view.board[j];
      Eigen::Matrix<double, 2, 3> J;
      const Eigen::Vector2d r = device::project(camera, turned + at.translation, J) - view.image[j];
      sum += r.squaredNorm();
      if (!equations) continue;
      Eigen::Matrix<double, 2, 6> Jp;
      Jp << -J * hat(turned), J;
      equations->add(Jp, r);
    }
    return sum;
  };
  minimise<6>(X, evaluate, moved<CameraOptical, Board>);
  NormalEquations<6> found;
  const double sum = evaluate(X, &found);
  normal = found.JtJ;
  return sum;
}

}  // namespace

Expected<Estimate<BoardPose>> board_pose(const device::CameraModel& camera, const BoardView& view,
                                         const BoardPoseOptions& options) {
  if (view.board.size() < 6 || view.board.size() != view.image.size())
    return refused("view '{}': {}, at least 6 are needed for a pose", view.name,
                   counted(view.image.size(), "corner"));
  std::vector<cv::Point3d> board;
  std::vector<cv::Point2d> rays;
  for (std::size_t j = 0; j < view.board.size(); ++j) {
    const auto ray = camera.undistort(
        {(view.image[j].x() - camera.cx) / camera.fx, (view.image[j].y() - camera.cy) / camera.fy});
    if (!ray)
      return refused(
          "view '{}': pixel ({:.1f}, {:.1f}) is beyond the lens model; calibrate the lens with views that "
          "reach there",
          view.name, view.image[j].x(), view.image[j].y());
    board.emplace_back(view.board[j].x(), view.board[j].y(), view.board[j].z());
    rays.emplace_back(ray->x(), ray->y());
  }
  std::vector<cv::Mat> turns, places;
  try {
    cv::solvePnPGeneric(board, rays, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turns, places, false,
                        cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    turns.clear();
  }
  Estimate<BoardPose> result;
  std::vector<double> sums;
  Matrix6 best_normal = Matrix6::Identity();
  std::vector<Pose<CameraOptical, Board>> minima;
  for (std::size_t k = 0; k < turns.size(); ++k) {
    const Vector3 turn(turns[k].at<double>(0), turns[k].at<double>(1), turns[k].at<double>(2));
    Pose<CameraOptical, Board> X{
        so3_exp(turn), Vector3(places[k].at<double>(0), places[k].at<double>(1), places[k].at<double>(2))};
    if (!X.translation.allFinite() || !turn.allFinite()) continue;
    Matrix6 normal;
    const double sum = refine(camera, view, X, normal);
    if (!std::isfinite(sum)) continue;
    if (sums.empty() || sum < *std::min_element(sums.begin(), sums.end())) {
      result.value.X_camera_board = X;
      best_normal = normal;
    }
    sums.push_back(sum);
    minima.push_back(X);
  }
  if (sums.empty())
    return refused("view '{}': no pose fits its corners; corners that do not lie on one line are needed",
                   view.name);
  const double n = static_cast<double>(view.board.size());
  const double first = *std::min_element(sums.begin(), sums.end());
  result.value.rms_px = std::sqrt(first / n);
  result.value.second_rms_px = std::sqrt(*std::max_element(sums.begin(), sums.end()) / n);
  // Both starts may lead to one minimum: then there is nothing to confuse it with.
  const bool two = minima.size() > 1 && angle_between(minima.front().rotation, minima.back().rotation) > 1e-3;
  result.value.ambiguous =
      two && result.value.second_rms_px < options.ambiguity_ratio * std::max(result.value.rms_px, 1e-9);
  if (result.value.rms_px > options.max_rms_px)
    return refused(
        "view '{}': the best pose leaves {:.2f} px rms, at most {:.2f} is expected; check lens, board and "
        "corners",
        view.name, result.value.rms_px, options.max_rms_px);
  const Vector6 values = symmetric_eigenvalues(best_normal);
  result.condition = std::sqrt(values.maxCoeff() / std::max(values.minCoeff(), 1e-300));
  result.covariance = (first / (2.0 * n - 6.0)) * covariance_from_information(best_normal);
  result.termination = Termination::converged;
  return result;
}

}  // namespace palpate::vision
