// Pictures cut from bytes in pieces of any size, with rubbish between them.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "ppm_stream.h"

namespace {

void expect(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "not so: %s\n", what);
  std::exit(1);
}

std::string picture(int width, int height, char value) {
  return "P6\n# made by hand\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n" +
         std::string(static_cast<std::size_t>(3 * width * height), value);
}

}  // namespace

int main() {
  const std::string all = picture(4, 2, 'a') + picture(3, 3, 'P') + "rubbish P6 x" + picture(2, 2, 'c') +
                          "P6 99999999 99999999 255\n" + picture(1, 1, 'd');
  for (std::size_t piece = 1; piece < all.size(); ++piece) {
    ppm::Stream stream;
    std::vector<ppm::Picture> got;
    for (std::size_t at = 0; at < all.size(); at += piece) {
      stream.add({all.data() + at, std::min(piece, all.size() - at)});
      while (auto next = stream.next()) got.push_back(*next);
    }
    expect(got.size() == 4, "four pictures");
    expect(got[0].width == 4 && got[0].height == 2 && got[0].rgb.size() == 24 && got[0].rgb[23] == 'a',
           "the first");
    expect(got[1].width == 3 && got[1].rgb == std::vector<std::uint8_t>(27, 'P'),
           "one that looks like headers");
    expect(got[2].width == 2 && got[2].rgb[0] == 'c', "the one behind rubbish");
    expect(got[3].width == 1 && got[3].rgb[2] == 'd', "the one behind a size that cannot be");
    expect(stream.damaged() == 2, "passed over twice");
  }
  return 0;
}
