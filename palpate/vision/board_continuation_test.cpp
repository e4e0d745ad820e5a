#include "palpate/vision/board_continuation.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "palpate/vision/synthetic_board.h"

namespace palpate::vision {
namespace {

// A board and where all its corners are.
struct BoardPicture {
  std::vector<std::uint8_t> grey;
  int width = 0, height = 0;
  BoardShape shape;
  std::vector<device::Pixel> corners;
};

std::vector<BoardPicture> drawn_boards(const BoardShape& shape, int count) {
  device::CameraModel camera;
  camera.width = 320, camera.height = 240, camera.fx = camera.fy = 280, camera.cx = 159.5, camera.cy = 119.5;
  camera.distortion = {-0.28, 0.09, 0.001, -0.0005, 0.0};
  Random random(1, "boards");
  std::vector<BoardPicture> pictures;
  for (int i = 0; i < count; ++i) {
    const auto X = synthetic::board_in_view(camera, shape, random);
    pictures.push_back({synthetic::draw_board(camera, X, shape), camera.width, camera.height, shape,
                        synthetic::view_of(camera, X, shape, 0.1, random).image});
  }
  return pictures;
}

std::vector<BoardPicture> chessboard_photographs() {
  const std::string folder = std::string(PALPATE_DATA_DIR) + "/opencv_chessboard_left/";
  const auto table = read_board_corners(folder + "corners_left.csv", {9, 6});
  EXPECT_TRUE(table);
  std::vector<BoardPicture> pictures;
  if (table)
    for (const auto& view : table->views) {
      const auto image = cv::imread(folder + view.name, cv::IMREAD_GRAYSCALE);
      pictures.push_back({{image.datastart, image.dataend}, image.cols, image.rows, {9, 6}, view.image});
    }
  EXPECT_EQ(pictures.size(), 13u);
  return pictures;
}

// The corners that are left where a part of the board is taken for the whole.
struct Part {
  int first_column = 0, first_row = 0, columns = 0, rows = 0;
};
BoardContinuation continuation_of(const BoardPicture& picture, const Part& part) {
  std::vector<device::Pixel> corners;
  for (int row = 0; row < part.rows; ++row)
    for (int column = 0; column < part.columns; ++column)
      corners.push_back(picture.corners[static_cast<std::size_t>(
          (part.first_row + row) * picture.shape.columns + part.first_column + column)]);
  return board_continuation(picture.grey, picture.width, picture.height, {part.columns, part.rows}, corners);
}

TEST(BoardContinuation, ABoardOfTheSizeToldEndsThere) {
  for (const BoardShape& shape : {BoardShape{9, 6}, BoardShape{8, 5}, BoardShape{5, 4}, BoardShape{11, 8}})
    for (const auto& picture : drawn_boards(shape, 6)) {
      const auto more = continuation_of(picture, {0, 0, shape.columns, shape.rows});
      EXPECT_EQ(more.columns + more.rows, 0) << shape.columns;
    }
  for (const auto& picture : chessboard_photographs()) {
    const auto more = continuation_of(picture, {0, 0, 9, 6});
    EXPECT_EQ(more.columns + more.rows, 0);
  }
}

TEST(BoardContinuation, ALargerBoardIsSeenToGoOn) {
  auto pictures = drawn_boards({9, 6}, 6);
  for (auto& photograph : chessboard_photographs()) pictures.push_back(std::move(photograph));
  for (const Part& part :
       {Part{0, 0, 8, 6}, Part{1, 0, 8, 6}, Part{0, 0, 9, 5}, Part{0, 1, 9, 5}, Part{1, 0, 7, 6}})
    for (const auto& picture : pictures) {
      const auto more = continuation_of(picture, part);
      EXPECT_EQ(more.columns, 9 - part.columns) << part.columns << "x" << part.rows;
      EXPECT_EQ(more.rows, 6 - part.rows) << part.columns << "x" << part.rows;
    }
}

TEST(BoardContinuation, IsCountedOverPhotographs) {
  const std::string images = std::string(PALPATE_DATA_DIR) + "/opencv_chessboard_left/left*.jpg";
  const auto right = read_board_images(images, {9, 6}), short_of_one = read_board_images(images, {8, 6});
  ASSERT_TRUE(right && short_of_one);
  EXPECT_EQ(right->goes_on, 0);
  EXPECT_GE(short_of_one->views.size(), 10u);
  EXPECT_EQ(static_cast<std::size_t>(short_of_one->goes_on), short_of_one->views.size());
  EXPECT_EQ(short_of_one->seen_shape.columns, 9);
  EXPECT_EQ(short_of_one->seen_shape.rows, 6);
}

TEST(BoardContinuation, WithoutCornersNothingIsSaid) {
  const auto picture = drawn_boards({9, 6}, 1).front();
  const auto more = board_continuation(picture.grey, picture.width, picture.height, {9, 6}, {});
  EXPECT_EQ(more.columns + more.rows, 0);
}

}  // namespace
}  // namespace palpate::vision
