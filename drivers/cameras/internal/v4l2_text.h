// What the Video4Linux driver knows of the kernel's structures and errors, in words. Functions without state.
#pragma once

#include <linux/videodev2.h>

#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "drivers/cameras/v4l2_source.h"

namespace palpate::drivers::cameras {

struct FourccName {
  std::uint32_t fourcc;
  PixelFormat format;
};
// The best first: what needs no guess of colours, then what is sent whole, then JPEG.
std::span<const FourccName> known_fourccs();

// The kernel wants what it does not know to be zero.
template <typename T>
T zeroed() {
  T value;
  std::memset(&value, 0, sizeof value);
  return value;
}

std::string fourcc_text(std::uint32_t fourcc);
std::string text_of(const __u8* bytes, std::size_t size);
// Why open() of that path failed with this errno, and what to do.
std::string opening_problem(const std::string& path, int error);
bool can_capture(const v4l2_capability& about);
std::vector<std::uint32_t> formats_of(V4l2Io& io, int fd);
std::vector<std::string> names_of(const std::vector<std::uint32_t>& fourccs);

}  // namespace palpate::drivers::cameras
