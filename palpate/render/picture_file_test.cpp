#include "palpate/render/picture_file.h"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <random>
#include <stdexcept>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::render {
namespace {

namespace fs = std::filesystem;

class PictureFile : public testing::Test {
 protected:
  ScratchFolder scratch_;
  const fs::path folder_ = scratch_.path();
};

std::vector<std::uint8_t> gradient(int width, int height, int shift) {
  std::vector<std::uint8_t> rgb;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      rgb.push_back(static_cast<std::uint8_t>(u + shift));
      rgb.push_back(static_cast<std::uint8_t>(2 * v));
      rgb.push_back(40);
    }
  }
  return rgb;
}

TEST_F(PictureFile, PngComesBackAsItWas) {
  const auto rgb = gradient(61, 33, 5);
  ASSERT_TRUE(write_png(folder_ / "a.png", rgb, 61, 33));
  const cv::Mat back = cv::imread((folder_ / "a.png").string());
  ASSERT_EQ(back.cols, 61);
  ASSERT_EQ(back.rows, 33);
  EXPECT_EQ(back.at<cv::Vec3b>(7, 3), cv::Vec3b(40, 14, 8));  // OpenCV reads blue first
  EXPECT_THROW(png_bytes(rgb, 60, 33), std::invalid_argument);
  EXPECT_FALSE(write_png(folder_ / "no" / "a.png", rgb, 61, 33));
}

TEST_F(PictureFile, VideoHasItsFramesAndAppearsOnlyWhenClosed) {
  {
    auto lost = VideoFile::create(folder_ / "lost.mp4", 64, 48, 30);
    ASSERT_TRUE(lost) << lost.error().message;
    lost->add(gradient(64, 48, 0));
  }
  EXPECT_TRUE(fs::is_empty(folder_));
  auto video = VideoFile::create(folder_ / "a.mp4", 64, 48, 30);
  ASSERT_TRUE(video);
  for (int i = 0; i < 12; ++i) video->add(gradient(64, 48, 4 * i));
  EXPECT_THROW(video->add(gradient(62, 48, 0)), std::invalid_argument);
  EXPECT_FALSE(fs::exists(folder_ / "a.mp4"));
  ASSERT_TRUE(video->close());
  cv::VideoCapture back((folder_ / "a.mp4").string(), cv::CAP_FFMPEG);
  int frames = 0;
  cv::Mat frame;
  while (back.read(frame)) {
    EXPECT_EQ(frame.cols, 64);
    ++frames;
  }
  EXPECT_EQ(frames, 12);
  EXPECT_FALSE(VideoFile::create(folder_ / "odd.mp4", 63, 48, 30));
  EXPECT_FALSE(VideoFile::create(folder_ / "no" / "a.mp4", 64, 48, 30));
}

// What the encoder keeps to itself: a file that may not grow is as good as a full disk, for root as well.
TEST_F(PictureFile, AVideoThatDoesNotFitIsRefusedAndLeavesNothing) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  for (const rlim_t room : {100u, 4000u, 40000u}) {  // header only; a part of the film; nearly all of it
    rlimit little = before;
    little.rlim_cur = room;
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &little), 0);
    auto video = VideoFile::create(folder_ / "a.mp4", 64, 48, 30);
    ASSERT_TRUE(video) << video.error().message;
    std::mt19937 noise(7);
    std::vector<std::uint8_t> rgb(64 * 48 * 3);
    for (int i = 0; i < 30; ++i) {
      for (auto& value : rgb) value = static_cast<std::uint8_t>(noise());
      video->add(rgb);
    }
    const auto closed = video->close();
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    ASSERT_FALSE(closed) << room;
    EXPECT_NE(closed.error().message.find("could not be written whole"), std::string::npos);
    EXPECT_TRUE(fs::is_empty(folder_)) << room;
  }
}

TEST_F(PictureFile, CaptionsChangeOnlyTheirCorner) {
  auto rgb = std::vector<std::uint8_t>(320u * 240u * 3u, 120);
  const auto before = rgb;
  burn_captions(rgb, 320, 240, {"score 3", "rally 7"});
  // Of two pictures side by side each has its own, alike.
  std::vector<std::uint8_t> both(2 * rgb.size(), 120);
  burn_captions(both, 640, 240, {"score 3", "rally 7"}, 2);
  for (std::size_t row = 0; row < 240; ++row)
    for (std::size_t eye = 0; eye < 2; ++eye)
      ASSERT_TRUE(std::equal(&rgb[row * 960], &rgb[row * 960] + 960, &both[row * 1920 + eye * 960])) << row;
  EXPECT_NE(rgb, before);
  EXPECT_TRUE(std::equal(rgb.begin() + 320 * 60 * 3, rgb.end(), before.begin() + 320 * 60 * 3));
}

}  // namespace
}  // namespace palpate::render
