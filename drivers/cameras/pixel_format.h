// Pictures as cameras send them, and their way to packed RGB, row 0 on top.
//
// Colours. YUYV and UYVY are ITU-R BT.601 (2011) with the studio's range (Y 16 to 235), as webcams send them;
// MJPEG is JPEG/JFIF. Bayer pictures are filled in bilinearly: half the resolution in red and blue, and no
// invented detail. The letters name the first row's first two pixels, as GenICam has them. Functions without
// state, any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::drivers::cameras {

enum class PixelFormat : std::uint8_t {
  rgb8,
  bgr8,
  mono8,
  bayer_rg8,
  bayer_gr8,
  bayer_gb8,
  bayer_bg8,
  yuyv,
  uyvy,
  mjpeg,
};
std::string_view name_of(PixelFormat format);
// By the name that name_of() gives, which is GenICam's where GenICam has the format.
std::optional<PixelFormat> format_named(std::string_view name);

struct RawPicture {
  PixelFormat format = PixelFormat::rgb8;
  int width = 0, height = 0;
  std::size_t stride = 0;  // bytes from row to row; 0: rows without a gap. Of no meaning in MJPEG
  std::span<const std::uint8_t> bytes;  // somebody else's
};

// Bytes of such a picture without gaps; 0 for MJPEG, whose size varies.
std::size_t packed_bytes(PixelFormat format, int width, int height);

// Refused, `rgb` being anything: fewer bytes than the size needs, an odd size where pixels come in pairs, a
// JPEG that is cut off, damaged or of another size than stated.
Expected<void> to_rgb(const RawPicture& picture, std::vector<std::uint8_t>& rgb);

}  // namespace palpate::drivers::cameras
