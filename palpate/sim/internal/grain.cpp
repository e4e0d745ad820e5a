#include "palpate/sim/internal/grain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "palpate/core/random.h"

namespace palpate::sim {

std::vector<std::uint8_t> grain(int size) {
  std::vector<double> sum(static_cast<std::size_t>(size * size), 0.5);
  Random random(1, "sim/grain");
  double weight = 0.22;
  for (int cells = 8; cells <= 128; cells *= 2, weight *= 0.68) {
    std::vector<double> value(static_cast<std::size_t>(cells * cells));
    for (double& v : value) v = random.uniform(-1.0, 1.0);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const double gx = static_cast<double>(x) * cells / size, gy = static_cast<double>(y) * cells / size;
        const int ix = static_cast<int>(gx), iy = static_cast<int>(gy);
        const auto smooth = [](double t) { return t * t * (3.0 - 2.0 * t); };
        const double a = smooth(gx - ix), b = smooth(gy - iy);
        const auto at = [&](int i, int j) {
          return value[static_cast<std::size_t>(((iy + j) % cells) * cells + (ix + i) % cells)];
        };
        sum[static_cast<std::size_t>(y * size + x)] +=
            weight *
            ((1 - b) * ((1 - a) * at(0, 0) + a * at(1, 0)) + b * ((1 - a) * at(0, 1) + a * at(1, 1)));
      }
    }
  }
  std::vector<std::uint8_t> bytes;
  bytes.reserve(sum.size());
  for (const double v : sum)
    bytes.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(v, 0.0, 1.0))));
  return bytes;
}

}  // namespace palpate::sim
