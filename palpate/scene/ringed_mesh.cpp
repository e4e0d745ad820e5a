#include "palpate/scene/ringed_mesh.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <vector>

namespace palpate::scene {

TriangleMesh ringed_mesh(std::uint32_t widest, const std::function<Vector3(std::uint32_t, double)>& place) {
  TriangleMesh mesh;
  const std::uint32_t last = 2 * widest;
  const auto size = [&](std::uint32_t r) { return 4 * std::min(r, last - r); };  // 0 at the ends
  std::vector<std::uint32_t> first;
  for (std::uint32_t r = 0; r <= last; ++r) {
    first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    const std::uint32_t count = std::max(1u, size(r));
    for (std::uint32_t i = 0; i < count; ++i)
      mesh.vertices.push_back(place(r, 2.0 * std::numbers::pi * i / count));
  }
  const auto at = [&](std::uint32_t r, std::uint32_t i) {
    return first[r] + (size(r) == 0 ? 0 : i % size(r));
  };
  for (std::uint32_t r = 0; r < last; ++r) {
    // The narrow ring of the two has n vertices in a quarter, the wide one n + 1.
    const bool widening = r < widest;
    const std::uint32_t narrow = widening ? r : r + 1, wide = widening ? r + 1 : r, n = size(narrow) / 4;
    for (std::uint32_t quarter = 0; quarter < 4; ++quarter)
      for (std::uint32_t i = 0; i <= n; ++i) {
        const std::uint32_t a = at(narrow, quarter * n + i);
        const std::uint32_t b = at(wide, quarter * (n + 1) + i), c = at(wide, quarter * (n + 1) + i + 1);
        mesh.triangles.push_back(widening ? std::array{a, b, c} : std::array{a, c, b});
        if (i == n) continue;
        const std::uint32_t d = at(narrow, quarter * n + i + 1);
        mesh.triangles.push_back(widening ? std::array{a, c, d} : std::array{a, d, c});
      }
  }
  return mesh;
}

}  // namespace palpate::scene
