#include "drivers/cameras/pixel_format.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>

#include "palpate/core/random.h"

namespace palpate::drivers::cameras {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes rgb_of(const RawPicture& picture) {
  Bytes rgb;
  const auto done = to_rgb(picture, rgb);
  EXPECT_TRUE(done) << done.error().message;
  return rgb;
}

Bytes noise(std::size_t size, int least = 0, int most = 255) {
  Random random(1, "pixel format test");
  Bytes bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.uniform(least, most + 0.999));
  return bytes;
}

// A smooth picture, red to the right, green downwards, blue against both.
Bytes smooth_rgb(int width, int height) {
  Bytes rgb;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double u = x / (width - 1.0), v = y / (height - 1.0);
      for (const double c : {40 + 160 * u, 60 + 120 * v, 200 - 60 * (u + v)})
        rgb.push_back(static_cast<std::uint8_t>(std::lround(c)));
    }
  return rgb;
}

int largest_difference(const Bytes& a, const Bytes& b) {
  EXPECT_EQ(a.size(), b.size());
  int largest = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST(PixelFormat, NamesLeadBack) {
  for (int i = 0; i <= static_cast<int>(PixelFormat::mjpeg); ++i) {
    const auto format = static_cast<PixelFormat>(i);
    EXPECT_EQ(format_named(name_of(format)), format);
  }
  EXPECT_FALSE(format_named("Mono12"));
}

TEST(PixelFormat, RowsWithGapsAndChannelsInOtherOrderComeOutPacked) {
  const Bytes in = noise(4 * 25);  // 7 px of 3 bytes and 4 bytes of gap, 4 rows; the last gap may be missing
  const Bytes rgb = rgb_of({PixelFormat::rgb8, 7, 4, 25, {in.data(), 3 * 25 + 21}});
  const Bytes bgr = rgb_of({PixelFormat::bgr8, 7, 4, 25, {in.data(), 3 * 25 + 21}});
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < 7; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(rgb[(y * 7 + x) * 3 + c], in[y * 25 + x * 3 + c]);
        EXPECT_EQ(bgr[(y * 7 + x) * 3 + c], in[y * 25 + x * 3 + 2 - c]);
      }
  const Bytes grey = rgb_of({PixelFormat::mono8, 10, 10, 0, in});
  for (std::size_t i = 0; i < 300; ++i) EXPECT_EQ(grey[i], in[i / 3]);
}

// The inverse of BT.601 in floating point: R = 1.164 (Y-16) + 1.596 (V-128) and so on. Rounding of both ways
// and the 20-bit integers of the fast way: 1.
TEST(PixelFormat, YuvIsTheEquationOfBt601) {
  const int width = 16, height = 8;
  const Bytes in = noise(2 * width * height, 16, 235);
  const auto clamped = [](double c) { return std::clamp(c, 0.0, 255.0); };
  for (const auto format : {PixelFormat::yuyv, PixelFormat::uyvy}) {
    const Bytes rgb = rgb_of({format, width, height, 0, in});
    const std::size_t y_at = format == PixelFormat::yuyv ? 0 : 1, c_at = 1 - y_at;
    for (std::size_t i = 0; i < static_cast<std::size_t>(width * height); ++i) {
      const double Y = 255.0 / 219.0 * (in[2 * i + y_at] - 16);
      const double U = 255.0 / 224.0 * (in[4 * (i / 2) + c_at] - 128),
                   V = 255.0 / 224.0 * (in[4 * (i / 2) + 2 + c_at] - 128);
      EXPECT_NEAR(rgb[3 * i], clamped(Y + 1.402 * V), 1.01);
      EXPECT_NEAR(rgb[3 * i + 1], clamped(Y - 0.344136 * U - 0.714136 * V), 1.01);
      EXPECT_NEAR(rgb[3 * i + 2], clamped(Y + 1.772 * U), 1.01);
    }
  }
}

// A smooth picture loses next to nothing when two thirds of it are thrown away and filled in bilinearly: 2 of
// 255, in the interior; a pattern taken for another would swap colours that differ by 100.
TEST(PixelFormat, EveryBayerPatternIsFilledIn) {
  const int width = 64, height = 48;
  const Bytes truth = smooth_rgb(width, height);
  const std::pair<PixelFormat, std::array<int, 4>> patterns[] = {{PixelFormat::bayer_rg8, {0, 1, 1, 2}},
                                                                 {PixelFormat::bayer_gr8, {1, 0, 2, 1}},
                                                                 {PixelFormat::bayer_gb8, {1, 2, 0, 1}},
                                                                 {PixelFormat::bayer_bg8, {2, 1, 1, 0}}};
  for (const auto& [format, colours] : patterns) {
    Bytes in;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        in.push_back(truth[static_cast<std::size_t>((y * width + x) * 3 +
                                                    colours[static_cast<std::size_t>(y % 2 * 2 + x % 2)])]);
    const Bytes rgb = rgb_of({format, width, height, 0, in});
    int largest = 0;
    for (int y = 2; y < height - 2; ++y)
      for (int i = (y * width + 2) * 3; i < (y * width + width - 2) * 3; ++i)
        largest = std::max(largest,
                           std::abs(rgb[static_cast<std::size_t>(i)] - truth[static_cast<std::size_t>(i)]));
    EXPECT_LE(largest, 4) << name_of(format);
  }
}

Bytes jpeg_of(const Bytes& rgb, int width, int height) {
  Bytes bgr = rgb, bytes;
  for (std::size_t i = 0; i < bgr.size(); i += 3) std::swap(bgr[i], bgr[i + 2]);
  cv::imencode(".jpg", cv::Mat(height, width, CV_8UC3, bgr.data()), bytes, {cv::IMWRITE_JPEG_QUALITY, 98});
  return bytes;
}

TEST(PixelFormat, AJpegOfAWebcamIsReadWithItsPaddingAndWithoutItsTables) {
  const int width = 64, height = 48;
  const Bytes truth = smooth_rgb(width, height);
  Bytes jpeg = jpeg_of(truth, width, height);
  EXPECT_LE(largest_difference(rgb_of({PixelFormat::mjpeg, width, height, 0, jpeg}), truth), 6);
  jpeg.insert(jpeg.end(), 40, 0);  // UVC cameras fill the buffer up
  EXPECT_LE(largest_difference(rgb_of({PixelFormat::mjpeg, width, height, 0, jpeg}), truth), 6);
  // Motion JPEG leaves the Huffman tables out (segments DHT, FF C4): they are the standard's.
  for (std::size_t at = 2; at + 4 < jpeg.size() && jpeg[at] == 0xFF && jpeg[at + 1] != 0xDA;) {
    const std::size_t length = 2u + (jpeg[at + 2] << 8 | jpeg[at + 3]);
    if (jpeg[at + 1] == 0xC4) {
      jpeg.erase(jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                 jpeg.begin() + static_cast<std::ptrdiff_t>(at + length));
    } else {
      at += length;
    }
  }
  EXPECT_LE(largest_difference(rgb_of({PixelFormat::mjpeg, width, height, 0, jpeg}), truth), 6);
}

TEST(PixelFormat, WhatIsCutOffDamagedOrOfAnotherSizeIsRefusedInWords) {
  Bytes rgb;
  const auto refusal = [&rgb](const RawPicture& picture) {
    const auto done = to_rgb(picture, rgb);
    return done ? std::string("accepted") : done.error().message;
  };
  const Bytes in = noise(64 * 48 * 3);
  EXPECT_EQ(refusal({PixelFormat::yuyv, 64, 48, 0, {in.data(), 100}}),
            "100 bytes came where a YUYV picture of 64x48 px has 6144");
  EXPECT_NE(refusal({PixelFormat::rgb8, 64, 48, 100, in}), "accepted");  // rows shorter than a row
  EXPECT_NE(refusal({PixelFormat::yuyv, 63, 48, 0, in}), "accepted");
  EXPECT_NE(refusal({PixelFormat::mono8, 0, 48, 0, in}), "accepted");
  const Bytes jpeg = jpeg_of(smooth_rgb(64, 48), 64, 48);
  EXPECT_NE(refusal({PixelFormat::mjpeg, 64, 48, 0, {jpeg.data(), jpeg.size() / 2}}).find("cut off"),
            std::string::npos);
  EXPECT_NE(refusal({PixelFormat::mjpeg, 32, 48, 0, jpeg}).find("64x48"), std::string::npos);
  EXPECT_NE(refusal({PixelFormat::mjpeg, 64, 48, 0, {in.data(), 2000}}), "accepted");
  Bytes hollow = {0xFF, 0xD8, 1, 2, 3, 0xFF, 0xD9};
  EXPECT_NE(refusal({PixelFormat::mjpeg, 64, 48, 0, hollow}).find("damaged"), std::string::npos);
  EXPECT_NE(refusal({PixelFormat::mjpeg, 64, 48, 0, {}}), "accepted");
}

}  // namespace
}  // namespace palpate::drivers::cameras
