#include "palpate/vision/camera.h"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/calib3d.hpp>

#include "palpate/core/units.h"
#include "palpate/vision/synthetic_board.h"
#include "tests/chi_square.h"

namespace palpate::vision {
namespace {

device::CameraModel reference_lens() {
  device::CameraModel camera;
  camera.fx = 560.0, camera.fy = 561.5, camera.cx = 318.7, camera.cy = 242.1;
  camera.distortion = {-0.28, 0.09, 0.001, -0.0005, 0.0};
  return camera;
}

Eigen::Matrix<double, 9, 1> parameters(const device::CameraModel& c) {
  Eigen::Matrix<double, 9, 1> p;
  p << c.fx, c.fy, c.cx, c.cy, c.distortion[0], c.distortion[1], c.distortion[2], c.distortion[3],
      c.distortion[4];
  return p;
}

// OpenCV 4.6 estimates the pixel variance as sum |r|^2 / (corners - parameters); a corner has two
// coordinates, so that its standard deviations are too large by the inverse of this factor.
double per_coordinate(int views, int corners) {
  const double parameters = 9.0 + 6.0 * views, n = views * corners;
  return std::sqrt((n - parameters) / (2.0 * n - parameters));
}

std::vector<BoardView> views_of(const device::CameraModel& camera, int count, double noise_px,
                                std::uint64_t seed) {
  Random random(seed, "camera test");
  std::vector<BoardView> views;
  for (int i = 0; i < count; ++i) {
    const auto X = synthetic::board_in_view(camera, {}, random);
    views.push_back(synthetic::view_of(camera, X, {}, noise_px, random, fmt::format("view{}", i)));
  }
  return views;
}

TEST(CalibrateCamera, PerfectCornersGiveTheLensBack) {
  const auto truth = reference_lens();
  const auto fit = calibrate_camera(views_of(truth, 12, 0.0, 1), 640, 480);
  ASSERT_TRUE(fit) << fit.error().message;
  const Eigen::Matrix<double, 9, 1> error = parameters(fit->value.model) - parameters(truth);
  EXPECT_LT(error.head<4>().cwiseAbs().maxCoeff(), 1e-3);  // OpenCV takes corners as float: 3e-5 px each
  EXPECT_LT(error.tail<5>().cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_LT(fit->value.rms_px, 1e-4);
  EXPECT_TRUE(fit->value.outlier_views().empty());
}

TEST(CalibrateCamera, ErrorsAgreeWithTheCovarianceItClaims) {
  const auto truth = reference_lens();
  double sum = 0.0;
  constexpr int kRuns = 25;
  for (int run = 0; run < kRuns; ++run) {
    const auto fit =
        calibrate_camera(views_of(truth, 10, 0.2, 100 + static_cast<std::uint64_t>(run)), 640, 480);
    ASSERT_TRUE(fit) << fit.error().message;
    const Eigen::Matrix<double, 9, 1> error = parameters(fit->value.model) - parameters(truth);
    sum += tests::normalised_square(error, fit->covariance.topLeftCorner<9, 9>());
  }
  EXPECT_TRUE(tests::is_sum_of_f(sum, kRuns, 9, 10 * 108 - 69));  // ten views of 54 corners, 69 parameters
}

// 120 degrees from corner to corner.
device::CameraModel rational_lens() {
  device::CameraModel camera;
  camera.fx = 420.0, camera.fy = 419.1, camera.cx = 317.4, camera.cy = 241.0;
  camera.distortion = {0.45, 0.05, 0.0006, -0.0004, 0.002, 0.78, 0.17, 0.011};
  camera.kind = device::LensKind::rational;
  return camera;
}

// 150 degrees from corner to corner.
device::CameraModel fisheye_lens() {
  device::CameraModel camera;
  camera.fx = 305.0, camera.fy = 304.2, camera.cx = 321.4, camera.cy = 238.0;
  camera.distortion = {0.021, -0.013, 0.004, -0.0009, 0.0};
  camera.kind = device::LensKind::fisheye;
  return camera;
}

// The board all around, up to 65 degrees from the axis, turned towards the camera but for some tilt.
std::vector<BoardView> views_all_around(int count, double noise_px, std::uint64_t seed,
                                        const device::CameraModel& camera = fisheye_lens()) {
  Random random(seed, "views all around");
  const BoardShape shape;
  const Vector3 middle = 0.5 * shape.corner(shape.corners() - 1);
  std::vector<BoardView> views;
  while (static_cast<int>(views.size()) < count) {
    const double angle = random.uniform(0.0, 1.13), round = random.uniform(-3.14, 3.14);
    const double right = random.uniform(-0.6, 0.6), up = random.uniform(-0.6, 0.6),
                 away = random.uniform(0.25, 0.5);
    const Quaternion towards = so3_exp(angle * Vector3(-std::sin(round), std::cos(round), 0.0));
    const Quaternion R = towards * so3_exp(Vector3(right, up, 0.0));
    const Pose<CameraOptical, Board> X{R, towards * Vector3(0.0, 0.0, away) - R * middle};
    auto view = synthetic::view_of(camera, X, shape, noise_px, random, fmt::format("view{}", views.size()));
    bool inside = true;
    for (std::size_t i = 0; i < view.board.size(); ++i) {
      const Vector3 p = X.rotation * view.board[i] + X.translation;
      inside = inside && p.z() > 0.05 && view.image[i].x() > 2 && view.image[i].y() > 2 &&
               view.image[i].x() < camera.width - 3 && view.image[i].y() < camera.height - 3;
    }
    if (inside) views.push_back(std::move(view));
  }
  return views;
}

TEST(CalibrateCamera, AWideLensProjectsAsOpenCvsFisheyeModule) {
  const auto lens = fisheye_lens();
  const cv::Matx33d K(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
  const cv::Vec4d k(lens.distortion[0], lens.distortion[1], lens.distortion[2], lens.distortion[3]);
  Random random(7, "wide lens");
  std::vector<cv::Point3d> places;
  for (int i = 0; i < 200; ++i) {
    const double x = random.uniform(-2.0, 2.0), y = random.uniform(-2.0, 2.0);
    places.emplace_back(x, y, random.uniform(0.5, 2.0));
  }
  std::vector<cv::Point2d> pixels;
  cv::fisheye::projectPoints(places, pixels, cv::Affine3d::Identity(), K, k);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto pixel = lens.project({places[i].x, places[i].y, places[i].z});
    EXPECT_NEAR(pixel.x(), pixels[i].x, 1e-9);
    EXPECT_NEAR(pixel.y(), pixels[i].y, 1e-9);
  }
}

TEST(CalibrateCamera, ARationalLensProjectsAsOpenCvs) {
  const auto lens = rational_lens();
  const cv::Matx33d K(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
  const std::vector<double> d(lens.distortion.begin(), lens.distortion.end());
  Random random(8, "rational lens");
  std::vector<cv::Point3d> places;
  for (int i = 0; i < 200; ++i) {
    const double x = random.uniform(-1.0, 1.0), y = random.uniform(-1.0, 1.0);
    places.emplace_back(x, y, random.uniform(0.8, 2.0));
  }
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(places, cv::Vec3d(), cv::Vec3d(), K, d, pixels);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto pixel = lens.project({places[i].x, places[i].y, places[i].z});
    EXPECT_NEAR(pixel.x(), pixels[i].x, 1e-9);
    EXPECT_NEAR(pixel.y(), pixels[i].y, 1e-9);
  }
}

// Its eight coefficients are hardly told apart, and so are judged by what they do together: where they put a pixel.
TEST(CalibrateCamera, ARationalLensPutsPixelsWhereItsCovarianceSays) {
  const auto truth = rational_lens();
  const CameraOptions rational{.lens = device::LensKind::rational};
  const auto off = [&](const device::CameraModel& found, const Vector3& ray) {
    return device::Pixel(found.project(ray) - truth.project(ray));
  };
  std::vector<Vector3> rays;
  for (int v = 40; v < 480; v += 100)
    for (int u = 40; u < 640; u += 140) {
      const auto n = truth.undistort({(u - truth.cx) / truth.fx, (v - truth.cy) / truth.fy});
      ASSERT_TRUE(n) << u << ' ' << v;
      rays.emplace_back(n->x(), n->y(), 1.0);
    }
  double sum = 0.0;
  int count = 0;
  for (int run = 0; run < 15; ++run) {
    const auto fit = calibrate_camera(views_all_around(14, 0.2, 500 + static_cast<std::uint64_t>(run), truth),
                                      640, 480, rational);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_NEAR(fit->value.rms_px, 0.2 * std::sqrt(2.0), 0.03);
    for (const auto& ray : rays) {
      const auto J = device::lens_jacobian(fit->value.model, ray);
      const Eigen::Matrix2d C = J * fit->covariance * J.transpose();
      const device::Pixel e = off(fit->value.model, ray);
      sum += e.dot(C.ldlt().solve(e)), count += 2;
    }
  }
  // One run's pixels hang together, so the mean wanders; twice as far off would be four times as much.
  EXPECT_GT(sum / count, 0.6);
  EXPECT_LT(sum / count, 1.6);
}

// Where Brown's coefficients say all, the others stay near 0, and pixels are where they were.
TEST(CalibrateCamera, ARationalFitOfAPlainLensSaysTheSame) {
  const auto truth = reference_lens();
  const auto views = views_of(truth, 12, 0.1, 7);
  const auto brown = calibrate_camera(views, 640, 480),
             rational = calibrate_camera(views, 640, 480, {.lens = device::LensKind::rational});
  ASSERT_TRUE(brown && rational);
  EXPECT_LT(rational->value.rms_px, brown->value.rms_px + 1e-6);
  for (int v = 60; v < 480; v += 90)
    for (int u = 60; u < 640; u += 130) {
      const auto n = truth.undistort({(u - truth.cx) / truth.fx, (v - truth.cy) / truth.fy});
      const Vector3 ray(n->x(), n->y(), 1.0);
      EXPECT_LT((rational->value.model.project(ray) - brown->value.model.project(ray)).norm(), 0.3)
          << u << ' ' << v;
    }
  for (const double k : rational->value.model.distortion) EXPECT_LT(std::abs(k), 5.0);
}

TEST(CalibrateCamera, AWideLensComesBackWithinItsCovariance) {
  const auto truth = fisheye_lens();
  const CameraOptions wide{.lens = device::LensKind::fisheye};
  const auto exact = calibrate_camera(views_all_around(15, 0.0, 1), 640, 480, wide);
  ASSERT_TRUE(exact) << exact.error().message;
  EXPECT_EQ(exact->value.model.kind, device::LensKind::fisheye);
  EXPECT_LT((parameters(exact->value.model) - parameters(truth)).head<4>().cwiseAbs().maxCoeff(), 1e-3);
  double sum = 0.0;
  constexpr int kRuns = 25;
  for (int run = 0; run < kRuns; ++run) {
    const auto fit =
        calibrate_camera(views_all_around(10, 0.2, 300 + static_cast<std::uint64_t>(run)), 640, 480, wide);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_EQ(fit->value.model.distortion[4], 0.0);
    EXPECT_EQ(fit->covariance(8, 8), 0.0);
    const Eigen::Matrix<double, 8, 1> error = (parameters(fit->value.model) - parameters(truth)).head<8>();
    sum += tests::normalised_square(error, fit->covariance.topLeftCorner<8, 8>());
  }
  EXPECT_TRUE(tests::is_sum_of_f(sum, kRuns, 8, 10 * 108 - 68));
  // Brown's polynomial does not fit so far out: the instrument can tell.
  const auto brown = calibrate_camera(views_all_around(15, 0.0, 1), 640, 480);
  ASSERT_TRUE(brown) << brown.error().message;
  EXPECT_GT(brown->value.rms_px, 0.04);
  EXPECT_LT(exact->value.rms_px, 1e-6);
}

TEST(CalibrateCamera, RealPhotographsAgreeWithThePublishedFit) {
  const auto read =
      read_board_corners(std::string(PALPATE_DATA_DIR) + "/opencv_chessboard_left/corners_left.csv", {});
  ASSERT_TRUE(read) << read.error().message;
  const auto fit = calibrate_camera(read->views, 640, 480);
  ASSERT_TRUE(fit) << fit.error().message;
  const auto& model = fit->value.model;
  EXPECT_NEAR(fit->value.rms_px, 0.4087,
              0.001);  // data/opencv_chessboard_left/ORIGIN.md: an independent run of the same model
  EXPECT_NEAR(model.fx, 536.073, 0.1);
  EXPECT_NEAR(model.fy, 536.016, 0.1);
  EXPECT_NEAR(model.cx, 342.370, 0.1);
  EXPECT_NEAR(model.cy, 235.537, 0.1);
  // The published standard deviations, 1.36 and 1.57, divide by the number of corners where there are two
  // numbers each.
  EXPECT_NEAR(fit->standard_deviation(0), 1.36 * per_coordinate(13, 54), 0.02);
  EXPECT_NEAR(fit->standard_deviation(3), 1.57 * per_coordinate(13, 54), 0.02);
  EXPECT_EQ(fit->value.outlier_views(), std::vector<std::string>{"left02.jpg"});
}

// data/camodocal_fisheye/ORIGIN.md: OpenCV's fisheye module on the same corners.
TEST(CalibrateCamera, RealFisheyePhotographsAgreeWithOpenCvs) {
  const auto read =
      read_board_corners(std::string(PALPATE_DATA_DIR) + "/camodocal_fisheye/corners.csv", {.square = 0.1});
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->views.size(), 60u);
  const auto fit =
      calibrate_camera(read->views, read->width, read->height, {.lens = device::LensKind::fisheye});
  ASSERT_TRUE(fit) << fit.error().message;
  const auto& model = fit->value.model;
  EXPECT_NEAR(fit->value.rms_px, 0.48582, 1e-4);
  EXPECT_NEAR(model.fx, 383.5691, 0.01);
  EXPECT_NEAR(model.fy, 384.6525, 0.01);
  EXPECT_NEAR(model.cx, 639.5380, 0.01);
  EXPECT_NEAR(model.cy, 477.3063, 0.01);
  const double k[] = {0.042753, -0.050022, 0.019845, -0.002943};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(model.distortion[i], k[i], 1e-4) << i;
  // Every second view tells the same lens, up to 74 degrees from the axis.
  std::vector<BoardView> half;
  for (std::size_t i = 0; i < read->views.size(); i += 2) half.push_back(read->views[i]);
  const auto other = calibrate_camera(half, read->width, read->height, {.lens = device::LensKind::fisheye});
  ASSERT_TRUE(other) << other.error().message;
  const auto& lens = other->value.model;
  double away = 0.0;
  for (double angle = 0.0; angle < 1.3; angle += 0.1)
    for (double turn = 0.0; turn < 6.28; turn += 0.4) {
      const Vector3 ray(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn), std::cos(angle));
      away = std::max(away, (lens.project(ray) - model.project(ray)).norm());
    }
  EXPECT_LT(away, 1.0);
  const auto brown = calibrate_camera(read->views, read->width, read->height);
  ASSERT_TRUE(brown) << brown.error().message;
  EXPECT_NE(brown->value.warnings.front().find("--lens-model fisheye"), std::string::npos)
      << brown->value.warnings.front();
}

TEST(CalibrateCamera, WindowsFittedToTheSquaresMendTheOutlierView) {
  const auto read =
      read_board_images(std::string(PALPATE_DATA_DIR) + "/opencv_chessboard_left/left*.jpg", {}, 0);
  ASSERT_TRUE(read) << read.error().message;
  const auto fit = calibrate_camera(read->views, read->width, read->height);
  ASSERT_TRUE(fit) << fit.error().message;
  // the fixed window reaches beyond the foreshortened squares of left02.jpg: 0.41 px over all with it
  EXPECT_LT(fit->value.rms_px, 0.26);
  EXPECT_TRUE(fit->value.outlier_views().empty());
}

TEST(CalibrateCamera, TheSizeOfTheSquaresDoesNotChangeTheLens) {
  const auto views = views_of(reference_lens(), 12, 0.2, 3);
  const auto fit = calibrate_camera(views, 640, 480);
  ASSERT_TRUE(fit);
  for (const double factor : {1e-4, 1e3}) {
    auto other = views;
    for (auto& view : other)
      for (auto& p : view.board) p *= factor;
    const auto same = calibrate_camera(other, 640, 480);
    ASSERT_TRUE(same) << same.error().message;
    const Eigen::Matrix<double, 9, 1> change = parameters(same->value.model) - parameters(fit->value.model);
    EXPECT_LT(change.cwiseAbs().maxCoeff(), 1e-3) << factor;
    const Vector3 place = fit->value.views[0].X_camera_board.translation,
                  moved = same->value.views[0].X_camera_board.translation;
    EXPECT_LT((moved / factor - place).norm(), 1e-6) << factor;
  }
}

TEST(CalibrateCamera, LeavingTheOutlierViewOutLowersTheResidual) {
  const auto read =
      read_board_corners(std::string(PALPATE_DATA_DIR) + "/opencv_chessboard_left/corners_left.csv", {});
  ASSERT_TRUE(read) << read.error().message;
  const auto fit = calibrate_camera(read->views, 640, 480, {.reject_outlier_views = true});
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_LT(fit->value.rms_px, 0.30);
  EXPECT_FALSE(fit->value.views[1].used);
  EXPECT_GT(fit->value.views[1].rms_px,
            1.0);  // still judged, by the pose it has under the lens of the others
}

TEST(CalibrateCamera, StandardDeviationsAreOpenCVsPerCoordinate) {
  const auto views = views_of(reference_lens(), 10, 0.2, 5);
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> image;
  for (const auto& view : views) {
    board.emplace_back(), image.emplace_back();
    for (const auto& p : view.board) board.back().emplace_back(float(p.x()), float(p.y()), 0.0f);
    for (const auto& p : view.image) image.back().emplace_back(float(p.x()), float(p.y()));
  }
  cv::Mat K, distortion, sd, sd_views, each;
  std::vector<cv::Mat> turns, places;
  cv::calibrateCamera(board, image, {640, 480}, K, distortion, turns, places, sd, sd_views, each);
  const auto fit = calibrate_camera(views, 640, 480);
  ASSERT_TRUE(fit);
  for (int i = 0; i < 9; ++i)
    EXPECT_NEAR(fit->standard_deviation(i) / (sd.at<double>(i) * per_coordinate(10, 54)), 1.0, 1e-3) << i;
}

TEST(CalibrateCamera, WarnsOfBoardsThatAreHardlyTurnedAgainstEachOther) {
  const auto truth = reference_lens();
  const auto warned = [&](double tilt_deg) {
    Random random(9, "camera test");
    std::vector<BoardView> views;
    for (int i = 0; i < 12; ++i) {
      const double about = i * std::numbers::pi / 6.0, tilt = 0.5 * radians_from_degrees(tilt_deg);
      const Quaternion turn = so3_exp(tilt * Vector3(std::cos(about), std::sin(about), 0.0));
      const Pose<CameraOptical, Board> X{turn, Vector3(-0.1, -0.06, 0.3 + 0.01 * i)};
      views.push_back(synthetic::view_of(truth, X, {}, 0.01, random, fmt::format("view{}", i)));
    }
    const auto fit = calibrate_camera(views, 640, 480);
    EXPECT_TRUE(fit) << fit.error().message;
    return fit && std::any_of(fit->value.warnings.begin(), fit->value.warnings.end(),
                              [](const auto& w) { return w.find("differ in tilt") != std::string::npos; });
  };
  EXPECT_TRUE(warned(15.0));
  EXPECT_FALSE(warned(25.0));
}

TEST(CalibrateCamera, RefusesWhatCannotCarryALens) {
  const auto truth = reference_lens();
  const auto two = calibrate_camera(views_of(truth, 2, 0.1, 1), 640, 480);
  ASSERT_FALSE(two);
  EXPECT_EQ(two.error().exit_code(), 1);

  Random random(1, "parallel");
  std::vector<BoardView> parallel;  // never tilted: focal length and distance cannot be told apart
  for (int i = 0; i < 8; ++i) {
    const Vector3 middle = 0.5 * BoardShape{}.corner(53);
    const Pose<CameraOptical, Board> X{Quaternion::Identity(),
                                       Vector3(0.02 * i - 0.07, 0.01 * i - 0.03, 0.5) - middle};
    parallel.push_back(synthetic::view_of(truth, X, {}, 0.3, random));
  }
  const auto flat = calibrate_camera(parallel, 640, 480);
  ASSERT_FALSE(flat);
  EXPECT_EQ(flat.error().exit_code(), 1);
  EXPECT_NE(flat.error().message.find("tilt"), std::string::npos);
}

TEST(BoardPose, PerfectCornersGiveThePoseBack) {
  const auto camera = reference_lens();
  Random random(2, "board pose");
  for (int i = 0; i < 20; ++i) {
    const auto X = synthetic::board_in_view(camera, {}, random);
    const auto pose = board_pose(camera, synthetic::view_of(camera, X, {}, 0.0, random));
    ASSERT_TRUE(pose) << pose.error().message;
    EXPECT_LT(angle_between(pose->value.X_camera_board.rotation, X.rotation), 1e-9);
    EXPECT_LT((pose->value.X_camera_board.translation - X.translation).norm(), 1e-9);
  }
}

TEST(BoardPose, ErrorsAgreeWithTheCovarianceItClaims) {
  const auto camera = reference_lens();
  Random random(3, "board pose noise");
  double sum = 0.0;
  constexpr int kRuns = 500;
  for (int i = 0; i < kRuns; ++i) {
    const auto X = synthetic::board_in_view(camera, {}, random);
    const auto pose = board_pose(camera, synthetic::view_of(camera, X, {}, 0.2, random));
    ASSERT_TRUE(pose) << pose.error().message;
    Eigen::Matrix<double, 6, 1> error;
    error << so3_log(X.rotation * pose->value.X_camera_board.rotation.conjugate()),
        X.translation - pose->value.X_camera_board.translation;
    sum += tests::normalised_square(error, pose->covariance);
  }
  EXPECT_TRUE(tests::is_sum_of_f(sum, kRuns, 6, 108 - 6));  // 54 corners, six parameters
}

TEST(BoardPose, ADistantNoisyBoardIsAmbiguousANearOneIsNot) {
  const auto camera = reference_lens();
  Random random(4, "ambiguous");
  const Quaternion tilt = so3_exp(Vector3(0.15, 0.0, 0.0));
  const auto far =
      board_pose(camera, synthetic::view_of(camera, {tilt, Vector3(0, 0, 6.0)}, {}, 0.5, random));
  ASSERT_TRUE(far) << far.error().message;
  EXPECT_TRUE(far->value.ambiguous);
  const auto near = board_pose(
      camera,
      synthetic::view_of(camera, {so3_exp(Vector3(0.5, 0, 0)), Vector3(-0.1, -0.07, 0.45)}, {}, 0.5, random));
  ASSERT_TRUE(near) << near.error().message;
  EXPECT_FALSE(near->value.ambiguous);
}

TEST(BoardPose, RefusesWhatFitsNoPose) {
  const auto camera = reference_lens();
  Random random(5, "mixed up");
  auto view = synthetic::view_of(camera, synthetic::board_in_view(camera, {}, random), {}, 0.1, random);
  std::swap(view.image[0], view.image[53]);
  EXPECT_FALSE(board_pose(camera, view));
  view.board.resize(4), view.image.resize(4);
  EXPECT_FALSE(board_pose(camera, view));
}

}  // namespace
}  // namespace palpate::vision
