// A recording of a camera as a folder of images: image files and a table of their times, `stamps.csv`, with the columns
// image (a file's name in the folder) and time_s (mid-exposure on the camera's clock, rising), and optionally frame
// (the camera's count).
#pragma once

#include <cstdint>
#include <string>

namespace palpate::device {

inline constexpr const char* kStampsFile = "stamps.csv";

// A time of that table: s with all digits of ns.
std::string stamp_text(std::int64_t ns);

}  // namespace palpate::device
