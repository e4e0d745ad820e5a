// What the head of a picture's file says of its size, before anything unpacks it: a file of kilobytes may hold
// a picture of gigabytes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"

namespace palpate::inline core {

// Larger than the pictures of any camera we know of that measures.
inline constexpr std::int64_t kMostPixels = 64'000'000;

struct PictureSize {
  std::int64_t width = 0, height = 0;
};

// Of a PNG, JPEG, BMP, TIFF or PNM (PGM, PPM). Wrong use where the file is none of these, where the picture
// has no pixel or more than kMostPixels, and where a JPEG is stored in more passes than any program writes.
Expected<PictureSize> picture_size(std::string_view content, const std::string& source);

}  // namespace palpate::inline core
