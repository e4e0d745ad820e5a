#include "palpate/core/picture_size.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <optional>

namespace palpate::inline core {
namespace {

using Size = std::optional<PictureSize>;

constexpr int kMostPasses = 64;    // of a progressive JPEG; programs write about 10
constexpr std::int64_t kOdd = -1;  // a side that no picture has
constexpr std::uint64_t kMostSide = 1u << 30;

// A number of `count` bytes at `at`; nothing beyond the end.
std::optional<std::uint64_t> bytes_at(std::string_view content, std::uint64_t at, unsigned count,
                                      bool big_endian) {
  if (at > content.size() || content.size() - at < count) return std::nullopt;
  std::uint64_t value = 0;
  for (unsigned i = 0; i < count; ++i) {
    const unsigned place = big_endian ? i : count - 1 - i;
    value = value << 8 | static_cast<unsigned char>(content[static_cast<std::size_t>(at) + place]);
  }
  return value;
}

std::int64_t side(std::optional<std::uint64_t> value) {
  return value && *value <= kMostSide ? static_cast<std::int64_t>(*value) : kOdd;
}

Size size_of_png(std::string_view content) {
  return PictureSize{side(bytes_at(content, 16, 4, true)), side(bytes_at(content, 20, 4, true))};
}

Size size_of_bmp(std::string_view content) {
  const auto signed_side = [content](std::uint64_t at) -> std::int64_t {  // a height below 0: from the top
    const auto value = bytes_at(content, at, 4, false);
    if (!value) return kOdd;
    return std::abs(static_cast<std::int64_t>(static_cast<std::int32_t>(*value)));
  };
  if (bytes_at(content, 14, 4, false) == 12u)
    return PictureSize{side(bytes_at(content, 18, 2, false)), side(bytes_at(content, 20, 2, false))};
  return PictureSize{signed_side(18), signed_side(22)};
}

// Two numbers in words, after a letter and a digit; lines that begin with '#' are comments.
Size size_of_pnm(std::string_view content) {
  PictureSize size{kOdd, kOdd};
  content.remove_prefix(2);
  for (std::int64_t* number : {&size.width, &size.height}) {
    while (!content.empty() && (content.front() == '#' || content.front() <= ' '))
      content.remove_prefix(content.front() == '#' ? std::min(content.find('\n'), content.size()) : 1);
    const auto [end, code] = std::from_chars(content.data(), content.data() + content.size(), *number);
    if (code != std::errc()) *number = kOdd;
    content.remove_prefix(static_cast<std::size_t>(end - content.data()));
  }
  return size;
}

// Of its first picture: the larger of the picture and of the tiles it is made of.
Size size_of_tiff(std::string_view content) {
  const bool big_endian = content.front() == 'M', large = bytes_at(content, 2, 2, big_endian) == 43u;
  const auto directory = bytes_at(content, large ? 8 : 4, large ? 8 : 4, big_endian);
  if (!directory) return PictureSize{kOdd, kOdd};
  const unsigned head = large ? 8 : 2, entry = large ? 20 : 12;
  const auto entries = bytes_at(content, *directory, head, big_endian);
  PictureSize size{kOdd, kOdd};
  for (std::uint64_t i = 0; entries && i < std::min<std::uint64_t>(*entries, 4096); ++i) {
    const std::uint64_t at = *directory + head + i * entry;
    const auto tag = bytes_at(content, at, 2, big_endian), type = bytes_at(content, at + 2, 2, big_endian);
    if (!tag || (*tag != 256 && *tag != 257 && *tag != 322 && *tag != 323)) continue;
    const unsigned bytes = type == 3u ? 2 : (type == 16u ? 8 : 4);
    const auto value = side(bytes_at(content, at + (large ? 12 : 8), bytes, big_endian));
    std::int64_t& of = *tag == 256 || *tag == 322 ? size.width : size.height;
    of = value == kOdd ? std::int64_t{kMostSide} : std::max(of, value);
  }
  return size;
}

// Where the compressed pixels that begin at `at` are over: at the next marker.
std::size_t after_pixels(std::string_view content, std::size_t at) {
  for (at = content.find('\xFF', at); at != std::string_view::npos; at = content.find('\xFF', at + 1)) {
    if (at + 1 >= content.size()) break;
    const auto next = static_cast<unsigned char>(content[at + 1]);
    if (next != 0x00 && next != 0xFF && (next < 0xD0 || next > 0xD7)) return at;
  }
  return content.size();
}

// Its segments one by one (ITU-T T.81, annex B), for the size and the number of passes.
Size size_of_jpeg(std::string_view content, int& passes) {
  PictureSize size{kOdd, kOdd};
  std::size_t at = 2;
  while (at + 4 <= content.size()) {
    const auto marker = static_cast<unsigned char>(content[at + 1]);
    if (content[at] != '\xFF' || marker == 0xFF || marker == 0x00) {
      ++at;  // what is left over between segments is passed over, as the decoder does
      continue;
    }
    if (marker == 0xD9) break;
    if (marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8)) {
      at += 2;
      continue;
    }
    const auto length = *bytes_at(content, at + 2, 2, true);
    const bool frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) {
      size.height = std::max(size.height, side(bytes_at(content, at + 5, 2, true)));
      size.width = std::max(size.width, side(bytes_at(content, at + 7, 2, true)));
    }
    at += 2 + std::max<std::size_t>(length, 2);
    if (marker == 0xDA) {
      ++passes;
      at = after_pixels(content, std::min(at, content.size()));
    }
  }
  return size;
}

}  // namespace

Expected<PictureSize> picture_size(std::string_view content, const std::string& source) {
  const auto begins = [content](std::string_view with) { return content.starts_with(with); };
  int passes = 0;
  Size size;
  if (begins("\x89PNG\r\n\x1A\n")) size = size_of_png(content);
  if (begins("\xFF\xD8\xFF")) size = size_of_jpeg(content, passes);
  if (begins("BM")) size = size_of_bmp(content);
  if (begins({"II*\0", 4}) || begins({"MM\0*", 4}) || begins({"II+\0", 4}) || begins({"MM\0+", 4}))
    size = size_of_tiff(content);
  if (content.size() > 2 && content[0] == 'P' && content[1] >= '1' && content[1] <= '6')
    size = size_of_pnm(content);
  if (!size || size->width <= 0 || size->height <= 0)
    return wrong_use("{}: is not an image this program can read; JPEG or PNG is expected", source);
  if (size->width > kMostPixels || size->height > kMostPixels || size->width * size->height > kMostPixels)
    return wrong_use("{}: is a picture of {}x{} px; at most {} million pixels are expected", source,
                     size->width, size->height, kMostPixels / 1'000'000);
  if (passes > kMostPasses)
    return wrong_use("{}: is a JPEG of {} passes; at most {} are expected, save it anew", source, passes,
                     kMostPasses);
  return *size;
}

}  // namespace palpate::inline core
