#include "palpate/core/picture_size.h"

#include <gtest/gtest.h>

#include "palpate/core/file.h"

namespace palpate::inline core {
namespace {

std::string big(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = bytes; i-- > 0;) text += static_cast<char>(value >> (8 * i));
  return text;
}
std::string little(std::uint64_t value, int bytes) {
  const auto turned = big(value, bytes);
  return {turned.rbegin(), turned.rend()};
}

std::string png(std::uint32_t width, std::uint32_t height) {
  return "\x89PNG\r\n\x1A\n" + big(13, 4) + "IHDR" + big(width, 4) + big(height, 4) + big(0x0800000000, 5);
}
std::string bmp(std::uint32_t width, std::uint32_t height) {
  return "BM" + std::string(12, 'x') + little(40, 4) + little(width, 4) + little(height, 4);
}
std::string tiff(std::uint32_t width, std::uint32_t height, std::uint32_t tile = 16) {
  const auto entry = [](int tag, std::uint32_t value) {
    return little(static_cast<std::uint64_t>(tag), 2) + little(4, 2) + little(1, 4) + little(value, 4);
  };
  return std::string("II*\0", 4) + little(8, 4) + little(3, 2) + entry(256, width) + entry(257, height) +
         entry(322, tile);
}
std::string big_tiff(std::uint64_t width, std::uint64_t height) {
  const auto entry = [](int tag, std::uint64_t value) {
    return big(static_cast<std::uint64_t>(tag), 2) + big(16, 2) + big(1, 8) + big(value, 8);
  };
  return std::string("MM\0+", 4) + big(8, 2) + big(0, 2) + big(16, 8) + big(2, 8) + entry(256, width) +
         entry(257, height);
}
std::string segment(int marker, const std::string& content) {
  return "\xFF" + big(static_cast<std::uint64_t>(marker), 1) + big(content.size() + 2, 2) + content;
}
// In its application segment is a small picture of its own, as cameras put there.
std::string jpeg(std::uint32_t width, std::uint32_t height, int passes = 1) {
  const auto frame = [](std::uint32_t w, std::uint32_t h) {
    return segment(0xC2, "\x08" + big(h, 2) + big(w, 2) + "\x01");
  };
  std::string all =
      "\xFF\xD8" + segment(0xE1, "\xFF\xD8" + frame(160, 120) + "\xFF\xD9") + frame(width, height);
  for (int i = 0; i < passes; ++i) all += segment(0xDA, "abc") + std::string("a\xFF\0b\xFF\xD0", 6);
  return all + "\xFF\xD9";
}
std::string words(std::uint32_t width, std::uint32_t height) {
  return fmt::format("P5\n# made by hand\n{} {}\n255\n", width, height);
}

TEST(PictureSize, IsReadFromTheHeadOfEachFormat) {
  for (const auto& made : {png(640, 480), bmp(640, 480), bmp(640, static_cast<std::uint32_t>(-480)),
                           tiff(640, 480), big_tiff(640, 480), jpeg(640, 480, 10), words(640, 480)}) {
    const auto size = picture_size(made, "a.png");
    ASSERT_TRUE(size.has_value()) << size.error().message;
    EXPECT_EQ(size->width, 640);
    EXPECT_EQ(size->height, 480);
  }
}

TEST(PictureSize, OfARecordedPictureIsWhatItsDecoderSays) {
  const auto content = read_file(PALPATE_DATA_DIR "/opencv_chessboard_left/left01.jpg");
  ASSERT_TRUE(content.has_value());
  EXPECT_EQ(picture_size(*content, "left01.jpg")->width, 640);
  EXPECT_EQ(picture_size(*content, "left01.jpg")->height, 480);
}

TEST(PictureSize, OfMorePixelsThanACameraHasIsRefused) {
  for (const auto& made : {png(16384, 16384), bmp(16384, 16384), tiff(16384, 16384), tiff(640, 480, 1u << 24),
                           big_tiff(1ull << 62, 1), jpeg(65500, 65500), words(16384, 16384),
                           png(0x7FFFFFFF, 0x7FFFFFFF), bmp(1u << 31, 1), png(0xFFFFFFFF, 1)}) {
    const auto size = picture_size(made, "a.png");
    ASSERT_FALSE(size.has_value());
    EXPECT_EQ(size.error().message.find("a.png: is "), 0u) << size.error().message;
    EXPECT_EQ(size.error().exit_code(), 2);
  }
  EXPECT_TRUE(picture_size(png(8000, 8000), "a.png").has_value());
}

// Each pass goes over all pixels, however little the file holds for it.
TEST(PictureSize, OfAJpegInThousandsOfPassesIsRefused) {
  const auto size = picture_size(jpeg(4000, 3000, 5000), "a.jpg");
  ASSERT_FALSE(size.has_value());
  EXPECT_NE(size.error().message.find("5000 passes"), std::string::npos) << size.error().message;
}

TEST(PictureSize, OfWhatIsNoPictureIsRefused) {
  for (const auto& made : {std::string(), std::string("text"), std::string("P5"), std::string("P5\nx 4\n"),
                           png(0, 5), std::string("\xFF\xD8\xFF"), std::string("BM"), std::string("II*\0", 4),
                           std::string("RIFF....WEBPVP8 ")})
    EXPECT_FALSE(picture_size(made, "a").has_value()) << made;
  // Cut off anywhere.
  for (const auto& made : {png(640, 480), bmp(640, 480), tiff(640, 480), big_tiff(640, 480), jpeg(640, 480)})
    for (std::size_t length = 0; length < made.size(); ++length)
      static_cast<void>(picture_size(std::string_view(made).substr(0, length), "a"));
}

}  // namespace
}  // namespace palpate::inline core
