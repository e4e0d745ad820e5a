#include "palpate/vision/board_continuation.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "palpate/vision/synthetic_board.h"

namespace palpate::vision {
namespace {

struct GreyPicture {
  std::vector<std::uint8_t> grey;
  int width = 0, height = 0;
};

// Over the corners of a board of that size; nothing where none was found.
std::optional<BoardContinuation> continuation_in(const GreyPicture& picture, const BoardShape& shape) {
  const auto corners = find_board_corners(picture.grey, picture.width, picture.height, shape);
  if (!corners) return std::nullopt;
  return board_continuation(picture.grey, picture.width, picture.height, shape, *corners);
}

std::vector<GreyPicture> drawn_boards(const BoardShape& shape, int count) {
  device::CameraModel camera;
  camera.width = 320, camera.height = 240, camera.fx = camera.fy = 280, camera.cx = 159.5, camera.cy = 119.5;
  camera.distortion = {-0.28, 0.09, 0.001, -0.0005, 0.0};
  Random random(1, "boards");
  std::vector<GreyPicture> pictures;
  for (int i = 0; i < count; ++i)
    pictures.push_back({synthetic::draw_board(camera, synthetic::board_in_view(camera, shape, random), shape),
                        camera.width, camera.height});
  return pictures;
}

std::vector<GreyPicture> chessboard_photographs() {
  std::vector<GreyPicture> pictures;
  for (int i = 1; i <= 14; ++i) {
    const auto image = cv::imread(fmt::format("{}/opencv_chessboard_left/left{:02}.jpg", PALPATE_DATA_DIR, i),
                                  cv::IMREAD_GRAYSCALE);
    if (!image.empty()) pictures.push_back({{image.datastart, image.dataend}, image.cols, image.rows});
  }
  EXPECT_EQ(pictures.size(), 13u);
  return pictures;
}

struct ContinuationCounts {
  int found = 0, columns = 0, rows = 0;
};
ContinuationCounts counts_over(const std::vector<GreyPicture>& pictures, const BoardShape& shape) {
  ContinuationCounts counts;
  for (const auto& picture : pictures)
    if (const auto more = continuation_in(picture, shape)) {
      ++counts.found;
      counts.columns += more->columns > 0 ? 1 : 0;
      counts.rows += more->rows > 0 ? 1 : 0;
    }
  return counts;
}

TEST(BoardContinuation, ABoardOfTheSizeToldEndsThere) {
  for (const BoardShape& shape : {BoardShape{9, 6}, BoardShape{8, 6}, BoardShape{5, 4}, BoardShape{13, 8}}) {
    const ContinuationCounts counts = counts_over(drawn_boards(shape, 6), shape);
    EXPECT_GE(counts.found, 4) << shape.columns;
    EXPECT_EQ(counts.columns + counts.rows, 0) << shape.columns;
  }
  const ContinuationCounts counts = counts_over(chessboard_photographs(), {9, 6});
  EXPECT_EQ(counts.found, 13);
  EXPECT_EQ(counts.columns + counts.rows, 0);
}

TEST(BoardContinuation, ALargerBoardIsSeenToGoOn) {
  const auto pictures = drawn_boards({9, 6}, 6);
  for (const BoardShape& told : {BoardShape{8, 6}, BoardShape{9, 5}, BoardShape{7, 5}}) {
    const ContinuationCounts counts = counts_over(pictures, told);
    EXPECT_GE(counts.found, 3) << told.columns << "x" << told.rows;
    EXPECT_EQ(counts.columns, told.columns < 9 ? counts.found : 0) << told.columns << "x" << told.rows;
    EXPECT_EQ(counts.rows, told.rows < 6 ? counts.found : 0) << told.columns << "x" << told.rows;
  }
}

TEST(BoardContinuation, PhotographsOfALargerBoardShowIt) {
  const ContinuationCounts counts = counts_over(chessboard_photographs(), {8, 6});
  EXPECT_GE(counts.found, 10);
  EXPECT_GE(2 * counts.columns, counts.found);
  EXPECT_EQ(counts.rows, 0);
}

TEST(BoardContinuation, WithoutCornersNothingIsSaid) {
  const GreyPicture picture = drawn_boards({9, 6}, 1).front();
  const auto more = board_continuation(picture.grey, picture.width, picture.height, {9, 6}, {});
  EXPECT_EQ(more.columns + more.rows, 0);
}

}  // namespace
}  // namespace palpate::vision
