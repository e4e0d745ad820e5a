#include "palpate/vision/board.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "palpate/core/file.h"
#include "palpate/core/random.h"
#include "palpate/vision/synthetic_board.h"
#include "tests/scratch_folder.h"

namespace palpate::vision {
namespace {

const std::string kData = std::string(PALPATE_DATA_DIR) + "/opencv_chessboard_left/";

TEST(Board, CornersOfADrawnBoardAreFoundWhereTheyAre) {
  device::CameraModel camera;
  camera.distortion = {-0.28, 0.09, 0.001, -0.0005, 0.0};
  const BoardShape shape;
  const Pose<CameraOptical, Board> X{so3_exp(Vector3(0.3, -0.25, 0.2)), Vector3(-0.11, -0.07, 0.5)};
  const auto found =
      find_board_corners(synthetic::draw_board(camera, X, shape), camera.width, camera.height, shape);
  ASSERT_TRUE(found);
  double sum = 0.0;
  for (int i = 0; i < shape.corners(); ++i) {
    const device::Pixel truth = camera.project(X.rotation * shape.corner(i) + X.translation);
    const double away = (found->at(static_cast<std::size_t>(i)) - truth).norm();
    EXPECT_LT(away, 0.15) << i;
    sum += away * away;
  }
  // sharp edges drawn with 4 x 4 rays a pixel alias: the refinement is good to about 0.05 px on them
  EXPECT_LT(std::sqrt(sum / shape.corners()), 0.08);
}

TEST(Board, NumberingFollowsTheBoardThroughHalfATurn) {
  device::CameraModel camera;
  camera.width = 320, camera.height = 240, camera.fx = camera.fy = 280, camera.cx = 159.5, camera.cy = 119.5;
  const BoardShape shape;
  const Vector3 middle = 0.5 * shape.corner(shape.corners() - 1);
  for (double turn : {0.0, 1.5, 3.14159, -1.5}) {
    const Quaternion R = so3_exp(Vector3(0.1, 0.2, 0)) * so3_exp(Vector3(0, 0, turn));
    const Pose<CameraOptical, Board> X{R, Vector3(0, 0, 0.5) - R * middle};
    const auto found =
        find_board_corners(synthetic::draw_board(camera, X, shape), camera.width, camera.height, shape);
    ASSERT_TRUE(found) << turn;
    EXPECT_LT((found->front() - camera.project(X.translation)).norm(), 1.0) << turn;
  }
}

TEST(Board, AnEmptyImageHasNoBoard) {
  const std::vector<std::uint8_t> grey(640 * 480, 128);
  EXPECT_FALSE(find_board_corners(grey, 640, 480, {}));
  EXPECT_FALSE(find_board_corners(grey, 320, 480, {}));  // size and pixels disagree
}

// The search for a board in it takes more than a minute.
TEST(Board, NoiseHasNoBoardAndIsLeftAtOnce) {
  Random random(1, "noise");
  std::vector<std::uint8_t> noise(1024 * 768);
  for (auto& pixel : noise) pixel = static_cast<std::uint8_t>(random.below(256));
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_FALSE(find_board_corners(noise, 1024, 768, {}));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(30));
}

// Many times larger than what is looked at first.
TEST(Board, ALargeImageOfABoardIsSearched) {
  const auto small = cv::imread(kData + "left01.jpg", cv::IMREAD_GRAYSCALE);
  ASSERT_FALSE(small.empty());
  cv::Mat large;
  cv::resize(small, large, {}, 4.0, 4.0, cv::INTER_CUBIC);
  const auto corners = find_board_corners({large.data, large.total()}, large.cols, large.rows, {});
  ASSERT_TRUE(corners);
  EXPECT_EQ(corners->size(), 54u);
}

TEST(Board, PhotographsGiveTheCornersOfTheTable) {
  const auto images = read_board_images(kData + "left*.jpg", {}, 11);
  const auto table = read_board_corners(kData + "corners_left.csv", {});
  ASSERT_TRUE(images) << images.error().message;
  ASSERT_TRUE(table) << table.error().message;
  ASSERT_EQ(images->views.size(), 13u);
  ASSERT_EQ(table->views.size(), 13u);
  EXPECT_EQ(images->width, 640);
  EXPECT_EQ(images->height, 480);
  EXPECT_TRUE(images->not_found.empty());
  std::vector<double> away;
  for (std::size_t i = 0; i < 13; ++i) {
    EXPECT_EQ(images->views[i].name, table->views[i].name);
    for (std::size_t j = 0; j < 54; ++j)
      away.push_back((images->views[i].image[j] - table->views[i].image[j]).norm());
  }
  std::sort(away.begin(), away.end());
  EXPECT_LT(away[away.size() / 2], 0.001);  // the same detector and window, told with four digits
}

// As the corners' table has them, within what JPEG leaves of a photograph.
TEST(Board, AFileIsSearchedLongerThanACamerasPicture) {
  const std::string file = std::string(PALPATE_DATA_DIR) + "/camodocal_fisheye/img17.jpg";
  const auto picture = cv::imread(file, cv::IMREAD_GRAYSCALE);
  ASSERT_FALSE(picture.empty());
  EXPECT_FALSE(find_board_corners({picture.data, picture.total()}, picture.cols, picture.rows, {}));
  const auto table = read_board_corners(std::string(PALPATE_DATA_DIR) + "/camodocal_fisheye/corners.csv", {});
  ASSERT_TRUE(table) << table.error().message;
  const auto there = std::find_if(table->views.begin(), table->views.end(),
                                  [](const BoardView& view) { return view.name == "img17.bmp"; });
  ASSERT_NE(there, table->views.end());
  const ScratchFolder folder;
  for (const int scale : {1, 2}) {  // the larger one is searched made smaller
    cv::Mat large;
    cv::resize(picture, large, {}, scale, scale, cv::INTER_CUBIC);
    ASSERT_TRUE(cv::imwrite((folder / "board.png").string(), large));
    const auto images = read_board_images((folder / "board.png").string(), {}, 5 * scale);
    ASSERT_TRUE(images) << images.error().message;
    ASSERT_EQ(images->views.size(), 1u) << scale;
    for (std::size_t j = 0; j < 54; ++j) {
      const device::Pixel corner = images->views[0].image[j].array() / scale + 0.5 / scale - 0.5;
      EXPECT_LT((corner - there->image[j]).norm(), 0.5) << j << " of the picture times " << scale;
    }
  }
}

// The search for a board in it takes more than a minute.
TEST(Board, AFileOfNoiseIsLeftAtOnce) {
  const ScratchFolder folder;
  Random random(1, "noise");
  cv::Mat noise(768, 1024, CV_8UC1);
  for (auto& pixel : cv::Mat_<std::uint8_t>(noise)) pixel = static_cast<std::uint8_t>(random.below(256));
  const auto file = folder / "noise.png";
  ASSERT_TRUE(cv::imwrite(file.string(), noise));
  const auto begun = std::chrono::steady_clock::now();
  const auto read = read_board_images(file.string(), {});
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->not_found, std::vector<std::string>{"noise.png"});
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(30));
}

// Squares of some 12 px: the usual window holds their neighbours' corners.
TEST(Board, WindowsAreFittedWhereSquaresAreSmall) {
  const ScratchFolder folder;
  const device::CameraModel camera;
  const BoardShape shape;
  const Pose<CameraOptical, Board> X{so3_exp(Vector3(0.5, -0.3, 0.2)), Vector3(-0.11, -0.07, 1.0)};
  const auto file = (folder / "small.png").string();
  auto drawn = synthetic::draw_board(camera, X, shape);
  ASSERT_TRUE(cv::imwrite(file, cv::Mat(camera.height, camera.width, CV_8UC1, drawn.data())));
  const auto rms = [&](std::optional<int> half_window) {
    const auto read = read_board_images(file, shape, half_window);
    if (!read || read->views.size() != 1) return 1e9;
    EXPECT_EQ(read->doubt.empty(), half_window.has_value());
    double sum = 0.0;
    for (int i = 0; i < shape.corners(); ++i)
      sum += (read->views[0].image[static_cast<std::size_t>(i)] -
              camera.project(X.rotation * shape.corner(i) + X.translation))
                 .squaredNorm();
    return std::sqrt(sum / shape.corners());
  };
  EXPECT_LT(rms({}), 0.1);
  EXPECT_EQ(rms({}), rms(0));
  EXPECT_GT(rms(kUsualHalfWindow), 0.2);
  const auto large = read_board_images(kData + "left01.jpg", {});
  ASSERT_TRUE(large);
  EXPECT_EQ(large->doubt, "");
}

TEST(Board, WrongFilesAreNamed) {
  const ScratchFolder folder;
  const auto message = [&](const std::string& content) {
    const auto file = folder / "corners.csv";
    EXPECT_TRUE(write_file(file, content));
    const auto read = read_board_corners(file.string(), {});
    EXPECT_FALSE(read);
    return read ? std::string() : read.error().message;
  };
  const std::string head = "image,corner,board_x_squares,board_y_squares,u_px,v_px\n";
  EXPECT_NE(message(head + "a,0,9,0,1,1\n").find(":2: corner at square (9, 0)"), std::string::npos);
  EXPECT_NE(message(head + "a,0,0,0,1,1\na,0,0,0,1,1\n").find("given twice"), std::string::npos);
  EXPECT_NE(message(head + "a,0,0,0,1,1\nb,0,0,0,1,1\na,0,0,0,1,1\n").find(":4: corner (0, 0) of 'a'"),
            std::string::npos);
  EXPECT_NE(message("image,corner,u_px,v_px\na,0,1,1\n").find("board_x_squares"), std::string::npos);
  EXPECT_NE(read_board_images((folder / "no_such_*.png").string(), {}).error().message.find("no such file"),
            std::string::npos);
  const auto text = folder / "palpate_not_an_image.png";
  ASSERT_TRUE(write_file(text, "hello"));
  EXPECT_NE(read_board_images(text.string(), {}).error().message.find("not an image"), std::string::npos);
}

// Files of a quarter of a megabyte unpack to 268 million pixels: searching them for a board took longer than
// anybody waits.
TEST(Board, AnImageIsMeasuredBeforeItIsUnpacked) {
  const ScratchFolder folder;
  const auto file = folder / "large.png";
  const std::string head("\x89PNG\r\n\x1A\n\0\0\0\rIHDR\0\0\x40\0\0\0\x40\0\x08\0\0\0\0", 29);
  ASSERT_TRUE(write_file(file, head));
  const auto read = read_board_images(file.string(), {});
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("is a picture of 16384x16384 px"), std::string::npos)
      << read.error().message;
  std::filesystem::create_symlink("/dev/zero", folder / "zero.png");
  EXPECT_NE(read_board_images((folder / "zero.png").string(), {}).error().message.find("is a device"),
            std::string::npos);
}

TEST(Board, ShapesAreReadStrictly) {
  const auto shape = board_shape("9x6", 0.025);
  ASSERT_TRUE(shape);
  EXPECT_EQ(shape->columns, 9);
  EXPECT_EQ(shape->rows, 6);
  for (const char* bad : {"", "9", "9x", "x6", "9x6x2", "9 x 6", "1x6", "-9x6", "9x6.5", "999x6"})
    EXPECT_FALSE(board_shape(bad, 0.025)) << bad;
  EXPECT_FALSE(board_shape("9x6", 0.0));
  EXPECT_FALSE(board_shape("9x6", -1.0));
}

}  // namespace
}  // namespace palpate::vision
