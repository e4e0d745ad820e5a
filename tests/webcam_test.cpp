// A printed board, from the page to the camera's pose: what is printed is where the page says, what a camera
// sees of it gives its place, and what it cannot see is said.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgcodecs.hpp>

#include "palpate/core/file.h"
#include "palpate/math/looking.h"
#include "palpate/rig/rig.h"
#include "palpate/server/graphics/conditions.h"
#include "palpate/vision/board_page.h"
#include "palpate/vision/camera.h"
#include "palpate/vision/charuco.h"
#include "palpate/vision/synthetic_charuco.h"
#include "tests/chi_square.h"
#include "tests/scratch_folder.h"

namespace palpate {
namespace {

constexpr double kMm = 1000.0;
const device::CameraModel kLens{640, 480, 560, 561.5, 318.7, 242.1, {-0.28, 0.09, 0.001, -0.0005, 0.0}};

std::vector<std::uint8_t> bytes_of(const cv::Mat& grey) {
  return {grey.data, grey.data + static_cast<std::size_t>(grey.cols) * static_cast<std::size_t>(grey.rows)};
}

device::CharucoBoard board_on(const vision::Paper& paper, int columns, int rows,
                              const std::string& dictionary) {
  device::CharucoBoard board{columns, rows, vision::largest_square(paper, columns, rows), 0.0, dictionary};
  board.marker = 0.74 * board.square;
  return board;
}

// As OpenCV's own ChArUco detector has it, absent where it found none. Its pixel (0, 0) is the first one's
// upper left corner.
std::vector<std::optional<device::Pixel>> opencv_corners(const cv::Mat& grey,
                                                         const device::CharucoBoard& board, int dictionary) {
  const auto set = cv::aruco::getPredefinedDictionary(dictionary);
  const auto theirs = cv::aruco::CharucoBoard::create(
      board.columns, board.rows, static_cast<float>(board.square), static_cast<float>(board.marker), set);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids, found;
  std::vector<cv::Point2f> places;
  cv::aruco::detectMarkers(grey, set, markers, ids);
  cv::aruco::interpolateCornersCharuco(markers, ids, grey, theirs, places, found);
  std::vector<std::optional<device::Pixel>> corners(static_cast<std::size_t>(board.corners()));
  for (std::size_t k = 0; k < found.size(); ++k)
    corners[static_cast<std::size_t>(found[k])] = device::Pixel(places[k].x - 0.5, places[k].y - 0.5);
  return corners;
}

// The page as a printer would have it, 1 px = 25.4 / dpi mm; empty where poppler could not draw it.
cv::Mat rendered(const vision::PdfPage& page, int dpi) {
  const ScratchFolder folder;
  if (!write_file(folder / "page.pdf", page.bytes())) return {};
  const std::string command = "pdftoppm -r " + std::to_string(dpi) + " -gray -png -singlefile " +
                              (folder / "page.pdf").string() + " " + (folder / "page").string();
  if (std::system(command.c_str()) != 0) return {};
  return cv::imread((folder / "page.png").string(), cv::IMREAD_GRAYSCALE);
}

TEST(BoardPage, EveryCornerIsPrintedWhereThePageSays) {
  struct Case {
    const char* paper;
    int columns, rows;
    const char* dictionary;
    int opencv;
  };
  double worst_mm = 0.0, worst_between_mm = 0.0;
  for (const Case& c : {Case{"a4", 7, 5, "4x4_50", cv::aruco::DICT_4X4_50},
                        Case{"a3", 9, 7, "5x5_100", cv::aruco::DICT_5X5_100},
                        Case{"letter", 5, 7, "6x6_250", cv::aruco::DICT_6X6_250}}) {
    SCOPED_TRACE(c.paper);
    const auto paper = vision::paper_for(c.paper, c.columns, c.rows);
    ASSERT_TRUE(paper);
    const device::CharucoBoard board = board_on(*paper, c.columns, c.rows, c.dictionary);
    const auto page = vision::board_page(*paper, board, vision::charuco_bits);
    ASSERT_TRUE(page) << page.error().message;
    constexpr int kDpi =
        200;  // a pixel is 0.127 mm: where a reader puts an edge between pixels is the tolerance
    const cv::Mat grey = rendered(*page, kDpi);
    ASSERT_FALSE(grey.empty());
    const double px = kDpi / 0.0254;  // per metre; pixel 0's centre lies half a pixel inside the page
    EXPECT_NEAR(grey.cols, paper->width * px, 1.0);
    const auto origin = vision::board_on_page(*paper, board);
    const auto sight = vision::find_charuco(bytes_of(grey), grey.cols, grey.rows, board);
    EXPECT_EQ(sight.markers, board.markers());
    ASSERT_EQ(static_cast<int>(sight.corners.size()), board.corners());
    const auto peer = opencv_corners(grey, board, c.opencv);
    for (std::size_t i = 0; i < sight.corners.size(); ++i) {
      const Vector3 corner = board.corner(sight.corners[i]);
      const device::Pixel truth =
          px * device::Pixel(origin[0] + corner.x(), origin[1] + corner.y()) - device::Pixel(0.5, 0.5);
      ASSERT_TRUE(peer[i]) << i;
      worst_mm = std::max(worst_mm, (sight.pixels[i] - truth).norm() / px * kMm);
      worst_between_mm = std::max(worst_between_mm, (sight.pixels[i] - *peer[i]).norm() / px * kMm);
    }
  }
  std::printf("[ printed ] worst corner %.3f mm off, ours to OpenCV's %.3f mm\n", worst_mm, worst_between_mm);
  EXPECT_LT(worst_mm, 0.1);
  EXPECT_LT(worst_between_mm, 0.02);
}

TEST(BoardPage, TheScaleBarIsAHundredMillimetresLong) {
  const auto paper = vision::paper_for("a4", 7, 5);
  const device::CharucoBoard board = board_on(*paper, 7, 5, "4x4_50");
  constexpr int kDpi = 300;
  const cv::Mat grey = rendered(*vision::board_page(*paper, board, vision::charuco_bits), kDpi);
  ASSERT_FALSE(grey.empty());
  const double px = kDpi / 0.0254;
  const auto bar = vision::bar_on_page(*paper, board);
  const int row = static_cast<int>(bar[1] * px),
            at = static_cast<int>((bar[0] + 0.5 * vision::kScaleBar) * px);
  const auto dark = [&](int column) {
    return std::min({grey.at<std::uint8_t>(row - 1, column), grey.at<std::uint8_t>(row, column),
                     grey.at<std::uint8_t>(row + 1, column)}) < 140;
  };
  int left = at, right = at;
  while (left > 0 && dark(left - 1)) --left;
  while (right + 1 < grey.cols && dark(right + 1)) ++right;
  // ticks are 0.2 mm wide, half of that stands out at either end
  EXPECT_NEAR((right - left + 1) / px * kMm, 100.2, 0.2);
}

TEST(BoardPage, WhatDoesNotFitIsSaid) {
  const auto paper = vision::paper_for("a4", 7, 5);
  device::CharucoBoard board = board_on(*paper, 7, 5, "4x4_50");
  board.square += 0.001;
  EXPECT_NE(
      vision::board_page(*paper, board, vision::charuco_bits).error().message.find("do not fit a4 paper"),
      std::string::npos);
  EXPECT_NE(vision::paper_for("a5", 7, 5).error().message.find("a4, a3 or letter"), std::string::npos);
}

TEST(CharucoBoard, WhatIsNoBoardIsNamed) {
  const auto fault = [](device::CharucoBoard board) { return device::charuco_fault(board); };
  EXPECT_EQ(fault({}), "");
  EXPECT_NE(fault({1, 5}).find("1x5 squares"), std::string::npos);
  EXPECT_NE(fault({7, 5, 0.035, 0.034}).find("marker of 34 mm"), std::string::npos);
  EXPECT_NE(fault({7, 5, 0.035, 0.026, "8x8_50"}).find("dictionary '8x8_50'"), std::string::npos);
  EXPECT_NE(fault({20, 20, 0.01, 0.007, "4x4_50"}).find("200 white squares"), std::string::npos);
  const ScratchFolder folder;
  const auto says = [&](const std::string& content) {
    EXPECT_TRUE(write_file(folder / "b.toml", content));
    const auto read = device::read_charuco_board(folder / "b.toml");
    return read ? std::string("read") : read.error().message;
  };
  EXPECT_EQ(says(device::charuco_board_text({})), "read");
  EXPECT_NE(says("columns = 7\nrows = 5\nsquare_mm = 35\nmarker_mm = 26\n").find("dictionary"),
            std::string::npos);
  EXPECT_NE(says(device::charuco_board_text({}) + "colour = 1\n").find("colour"), std::string::npos);
  EXPECT_NE(says("columns = 7\nrows = 5\nsquare_mm = -35\nmarker_mm = 26\ndictionary = \"4x4_50\"\n")
                .find("square_mm"),
            std::string::npos);
}

TEST(DeskRig, IsTheSameAfterItWasWrittenAndRead) {
  const rig::Rig rig = rig::desk_rig(device::CharucoBoard{}.printed_with(0.0347), 0.6, 0.8);
  const auto again = rig::parse_rig(rig::rig_text(rig), "desk.toml");
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_TRUE(again->board);
  EXPECT_NEAR(again->board->board.square, 0.0347, 1e-12);
  EXPECT_NEAR(again->board->board.marker, 0.026 * 0.0347 / 0.035, 1e-12);
  EXPECT_LT((again->board->X_world_board.translation - rig.board->X_world_board.translation).norm(), 1e-12);
  EXPECT_EQ(again->arm->model.name, rig::kMouseArm);
  const auto missing = rig::missing_parts(*again);
  ASSERT_EQ(missing.size(), 1u);
  EXPECT_EQ(missing.front().part, "camera");
  // The board lies on the table, its face up.
  const auto& X = again->board->X_world_board;
  EXPECT_NEAR(X.translation.y(), again->surface("table")->corner(0).m.y(), 1e-12);
  EXPECT_LT((X.rotation * -Vector3::UnitZ() - Vector3::UnitY()).norm(), 1e-12);
}

TEST(Charuco, APhotographGivesAllCornersWhereOpenCvHasThem) {
  const cv::Mat grey =
      cv::imread(std::string(PALPATE_DATA_DIR) + "/charuco_photograph/choriginal.jpg", cv::IMREAD_GRAYSCALE);
  ASSERT_EQ(grey.cols, 640);
  const device::CharucoBoard board{5, 7, 0.04, 0.02, "6x6_250"};
  const auto sight = vision::find_charuco(bytes_of(grey), grey.cols, grey.rows, board);
  EXPECT_EQ(sight.markers, 17);
  EXPECT_EQ(sight.strangers, 0);
  ASSERT_EQ(sight.corners.size(), 24u);
  const auto peer = opencv_corners(grey, board, cv::aruco::DICT_6X6_250);
  double worst = 0.0;
  for (std::size_t i = 0; i < 24; ++i) {
    ASSERT_TRUE(peer[i]) << i;
    worst = std::max(worst, (sight.pixels[i] - *peer[i]).norm());
  }
  std::printf("[ photograph ] ours to OpenCV's corners %.3f px at most\n", worst);
  EXPECT_LT(worst, 0.3);  // other windows, other pixels
  // Nobody knows the lens: the focal length that fits best, and the pose with it.
  device::CameraModel lens;
  std::optional<vision::BoardPose> best;
  double focus = 0.0;
  for (double f = 300.0; f < 1500.0; f *= 1.02) {
    lens.fx = lens.fy = f;
    const auto pose =
        vision::board_pose(lens, vision::charuco_view(board, sight, "photograph"), {.max_rms_px = 1e9});
    if (pose && (!best || pose->value.rms_px < best->rms_px)) best = pose->value, focus = f;
  }
  ASSERT_TRUE(best);
  std::printf("[ photograph ] focal length %.0f px, %.3f px rms, board at %.3f m\n", focus, best->rms_px,
              best->X_camera_board.translation.z());
  EXPECT_LT(best->rms_px, 1.0);
  EXPECT_GT(focus, 400.0);
  EXPECT_LT(focus, 1000.0);
  // Another board of the same markers is not taken for this one.
  EXPECT_EQ(vision::find_charuco(bytes_of(grey), 640, 480, {}).markers, 0);
  EXPECT_EQ(vision::other_dictionary(bytes_of(grey), 640, 480, "4x4_50").value_or("none"), "6x6_50");
}

// The rays of its lens take a second to find: once for all tests.
const vision::synthetic::CharucoCamera& over_the_desk() {
  static const vision::synthetic::CharucoCamera camera(kLens, device::CharucoBoard{});
  return camera;
}

// A head over the desk: what is seen at frame i, and from where.
struct Desk {
  device::CharucoBoard board;
  rig::Rig rig = rig::desk_rig(board);
  const vision::synthetic::CharucoCamera& camera = over_the_desk();
  Random random{3, "desk"};

  const Pose<World, Board>& X_world_board() const { return rig.board->X_world_board; }
  Vector3 middle() const { return (X_world_board() * Point<Board>{board.middle()}).m; }
  Pose<World, CameraOptical> head(int i) const {
    const double t = i / 30.0;
    const Vector3 eye = middle() + Vector3(0.15 * std::sin(2.0 * t), 0.50 + 0.04 * std::sin(3.1 * t), 0.40);
    return looking(eye, middle() + Vector3(0.04 * std::sin(5.0 * t), 0.0, -0.05));
  }
  std::vector<std::uint8_t> picture(
      const Pose<World, CameraOptical>& X,
      const std::optional<vision::synthetic::CharucoCamera::Cover>& cover = {}) {
    return camera.grey(X.inverse() * X_world_board(), 2.0, random, cover);
  }
  Expected<vision::RefinedPose> pose(const std::vector<std::uint8_t>& grey,
                                     const std::optional<Pose<World, CameraOptical>>& near = {}) const {
    const auto sight = vision::find_charuco(grey, kLens.width, kLens.height, board);
    return vision::camera_from_charuco(kLens, board, X_world_board(), sight, near);
  }
};

struct PoseErrors {
  double squared_mm = 0.0, squared_px = 0.0, normalised = 0.0;
  int frames = 0;
  void add(const Desk& desk, const Pose<World, CameraOptical>& truth, const vision::RefinedPose& found) {
    const auto& X = found.X_world_camera;
    squared_mm += (X.translation - truth.translation).squaredNorm() * kMm * kMm;
    // Points of the table up to 30 cm from the middle of the board, as a picture draws them.
    double sum = 0.0;
    int count = 0;
    for (const double x : {-0.25, 0.0, 0.25})
      for (const double z : {-0.2, 0.0, 0.15}) {
        const Point<World> p{desk.middle() + Vector3(x, 0.0, z)};
        sum += (kLens.project_undistorted((X.inverse() * p).m) -
                kLens.project_undistorted((truth.inverse() * p).m))
                   .squaredNorm();
        ++count;
      }
    squared_px += sum / count;
    Vector6 e;
    e << so3_log(X.rotation * truth.rotation.conjugate()), X.translation - truth.translation;
    normalised += e.dot(found.covariance.ldlt().solve(e)) / 6.0;
    ++frames;
  }
  double rms_mm() const { return std::sqrt(squared_mm / frames); }
  double rms_px() const { return std::sqrt(squared_px / frames); }
};

TEST(CharucoPose, AMovingHeadIsFollowedToTheTenthOfAPixel) {
  Desk desk;
  PoseErrors errors;
  std::optional<Pose<World, CameraOptical>> near;
  for (int i = 0; i < 12; ++i) {
    const auto truth = desk.head(4 * i);
    const auto found = desk.pose(desk.picture(truth), near);
    ASSERT_TRUE(found) << i << ": " << found.error().message;
    EXPECT_EQ(found->inliers, 24) << i;
    errors.add(desk, truth, *found);
    near = found->X_world_camera;
  }
  std::printf("[ moving head ] camera %.3f mm rms, table %.3f px rms, normalised error %.2f\n",
              errors.rms_mm(), errors.rms_px(), errors.normalised / errors.frames);
  EXPECT_LT(errors.rms_mm(), 1.0);
  EXPECT_LT(errors.rms_px(), 0.3);
  // A corner's deviation is stated as photographs have it, for all lights and printers: it is larger here, by a factor of
  // two at most.
  const int degrees = 6 * errors.frames;
  EXPECT_TRUE(tests::is_at_most_chi_square(6.0 * errors.normalised, degrees));
  EXPECT_GT(6.0 * errors.normalised, 0.25 * tests::chi_square_bracket(degrees).low);
}

TEST(CharucoPose, ABoardHalfCoveredIsEnough) {
  Desk desk;
  PoseErrors errors;
  const double middle = desk.board.middle().x();
  for (int i = 0; i < 5; ++i) {
    const auto truth = desk.head(18 * i);
    const auto found =
        desk.pose(desk.picture(truth, vision::synthetic::CharucoCamera::Cover{middle, 1.0, -1.0, 1.0}));
    ASSERT_TRUE(found) << i << ": " << found.error().message;
    EXPECT_LE(found->inliers, 12) << i;
    errors.add(desk, truth, *found);
  }
  std::printf("[ half covered ] camera %.3f mm rms, table %.3f px rms\n", errors.rms_mm(), errors.rms_px());
  EXPECT_LT(errors.rms_mm(), 3.0);
  EXPECT_LT(errors.rms_px(), 1.0);
}

TEST(CharucoPose, WhatCannotBeSeenIsSaidInWords) {
  Desk desk;
  const auto away = looking(desk.middle() + Vector3(0, 0.5, 0.4), desk.middle() + Vector3(3, 0, 0));
  const auto nothing = desk.pose(desk.picture(away));
  ASSERT_FALSE(nothing);
  EXPECT_NE(nothing.error().message.find("0 of its 24 corners are seen"), std::string::npos);

  // The sheet that lies there has other markers.
  const auto here = desk.picture(desk.head(0));
  device::CharucoBoard other = desk.board;
  other.dictionary = "6x6_250";
  EXPECT_EQ(vision::find_charuco(here, kLens.width, kLens.height, other).markers, 0);
  EXPECT_EQ(vision::other_dictionary(here, kLens.width, kLens.height, "6x6_250").value_or("none"), "4x4_50");

  // The same markers in other squares: nothing fits.
  device::CharucoBoard turned{5, 7, 0.035, 0.026, "4x4_50"};
  const auto sight = vision::find_charuco(here, kLens.width, kLens.height, turned);
  EXPECT_GT(sight.markers, 10);
  const auto wrong = vision::camera_from_charuco(kLens, turned, desk.X_world_board(), sight, {});
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("do not stand as on a board of 5x7 squares"), std::string::npos)
      << wrong.error().message;
}

TEST(BoardCondition, IsToldWithinHalfASecondAndEndsByItself) {
  server::graphics::ConditionWatch watch(640, 480);
  watch.set_on_board();
  const auto at = [](int ms) { return Instant<GraphicsClock>{std::chrono::milliseconds(ms)}; };
  const auto kinds = [&] {
    std::vector<device::HealthCode> list;
    for (const auto& condition : watch.health().conditions()) list.push_back(condition.code);
    return list;
  };
  std::optional<int> told, ended;
  for (int ms = 0; ms < 3000; ++ms) {
    if (ms % 33 == 0) {
      watch.image(at(ms), 640, 480);
      watch.board(at(ms), ms < 1000 || ms >= 2000, "0 of its 24 corners are seen");
    }
    watch.look(at(ms));
    const auto now = kinds();
    if (!now.empty()) {
      EXPECT_EQ(now, std::vector{device::HealthCode::board_lost}) << ms;  // and nobody misses a tracker
      if (!told) told = ms;
    } else if (told && !ended) {
      ended = ms;
    }
  }
  ASSERT_TRUE(told && ended);
  EXPECT_GT(*told, 1000);
  EXPECT_LT(*told, 1500);
  EXPECT_LT(*ended, 2040);
}

}  // namespace
}  // namespace palpate
