#include "ppm_stream.h"

#include <array>
#include <cctype>

namespace ppm {
namespace {

constexpr std::size_t kLongestHeader = 256;  // bytes

struct Header {
  std::array<int, 3> numbers{};  // width, height, largest value
  std::size_t size = 0;          // 0: not whole yet
  bool bad = false;
};

// Three numbers after "P6", with blanks and comments between, and one blank at the end.
Header header_of(const std::string& bytes) {
  Header header;
  std::size_t at = 2;
  for (int& number : header.numbers) {
    while (at < bytes.size() &&
           (std::isspace(static_cast<unsigned char>(bytes[at])) != 0 || bytes[at] == '#')) {
      if (bytes[at] == '#')
        while (at < bytes.size() && bytes[at] != '\n') ++at;
      else
        ++at;
    }
    const std::size_t begin = at;
    while (at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9' && at - begin < 9)
      number = 10 * number + (bytes[at++] - '0');
    if (at < bytes.size() && (at == begin || std::isspace(static_cast<unsigned char>(bytes[at])) == 0))
      return {.bad = true};
  }
  const bool whole = at < bytes.size();
  if (!whole) return {.bad = bytes.size() > kLongestHeader};
  const auto& [width, height, most] = header.numbers;
  header.bad = width < 1 || height < 1 || most != 255 || width > Stream::kMostPixels / height;
  header.size = at + 1;
  return header;
}

}  // namespace

void Stream::add(std::span<const char> bytes) { waiting_.append(bytes.begin(), bytes.end()); }

// Whether the bytes that wait begin as a picture does.
bool Stream::find_begin() {
  const auto at = waiting_.find("P6");
  if (at != 0 && !waiting_.empty() && waiting_ != "P" && in_step_) {
    ++damaged_;
    in_step_ = false;
  }
  if (at == std::string::npos) {
    waiting_.erase(0, waiting_.size() - (waiting_.ends_with('P') ? 1 : 0));
    return false;
  }
  waiting_.erase(0, at);
  return true;
}

std::optional<Picture> Stream::next() {
  while (find_begin()) {
    const Header header = header_of(waiting_);
    if (header.bad) {
      waiting_.erase(0, 2);
      if (in_step_) ++damaged_;
      in_step_ = false;
      continue;
    }
    const auto [width, height, most] = header.numbers;
    const std::size_t pixels = 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (header.size == 0 || waiting_.size() < header.size + pixels) return std::nullopt;
    Picture picture{width, height, {}};
    const auto begin = waiting_.begin() + static_cast<std::ptrdiff_t>(header.size);
    picture.rgb.assign(begin, begin + static_cast<std::ptrdiff_t>(pixels));
    waiting_.erase(0, header.size + pixels);
    in_step_ = true;
    return picture;
  }
  return std::nullopt;
}

}  // namespace ppm
