#include "palpate/sim/internal/picture_tiles.h"

#include <epoxy/gl.h>

#include <algorithm>

namespace palpate::sim {

PictureTiles::PictureTiles(int width, int height, const std::vector<Eigen::Vector2f>& rays)
    : width_(width), height_(height), columns_((width + kSide - 1) / kSide) {
  const auto ray = [&](int u, int v) {
    return Eigen::Vector2d(
        rays[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)]
            .cast<double>());
  };
  for (int v = 0; v < height; v += kSide) {
    for (int u = 0; u < width; u += kSide) {
      const int right = std::min(u + kSide, width) - 1, below = std::min(v + kSide, height) - 1;
      corners_.push_back({ray(u, v), ray(right, v), ray(right, below), ray(u, below)});
    }
  }
}

std::vector<TileCover> PictureTiles::cover(const Matrix3& to_plane, const Eigen::Vector2d& low,
                                           const Eigen::Vector2d& high) const {
  constexpr double border = 0.02;   // m; more than half a pixel's footprint and the bend of a tile's edge
  constexpr double no_ray = 100.0;  // beyond it the lens folds back, and the corners say nothing
  std::vector<TileCover> covers;
  covers.reserve(corners_.size());
  for (const auto& corners : corners_) {
    bool whole = true, behind = true, in_front = true, known = true;
    std::array<bool, 4> outside{true, true, true, true};  // all corners beyond this side
    for (const auto& ray : corners) {
      const Vector3 h = to_plane * Vector3(ray.x(), ray.y(), 1.0);
      known = known && ray.cwiseAbs().maxCoeff() < no_ray;
      (h.z() > 0 ? behind : in_front) = false;
      const std::array<double, 4> within{h.x() - low.x() * h.z(), high.x() * h.z() - h.x(),
                                         h.y() - low.y() * h.z(), high.y() * h.z() - h.y()};
      for (std::size_t i = 0; i < 4; ++i) {
        whole = whole && within[i] > border * h.z();
        outside[i] = outside[i] && within[i] < -border * h.z();
      }
    }
    const bool missed =
        behind || (in_front && std::any_of(outside.begin(), outside.end(), [](bool o) { return o; }));
    covers.push_back(!known              ? TileCover::part
                     : missed            ? TileCover::none
                     : whole && in_front ? TileCover::whole
                                         : TileCover::part);
  }
  return covers;
}

void PictureTiles::draw(const std::vector<char>& wanted) {
  quads_.vertices.clear();
  quads_.indices.clear();
  const auto tile = [&](int column, int row) {
    return wanted[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)] != 0;
  };
  for (int row = 0; row * kSide < height_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      if (!tile(column, row)) continue;
      const int begin = column;  // neighbours in a row are drawn as one
      while (column + 1 < columns_ && tile(column + 1, row)) ++column;
      const int left = begin * kSide, right = std::min((column + 1) * kSide, width_);
      const int above = row * kSide, below = std::min((row + 1) * kSide, height_);
      const auto first = static_cast<std::uint32_t>(quads_.vertices.size());
      for (const auto& [x, y] : {std::pair{left, above}, std::pair{right, above}, std::pair{right, below},
                                 std::pair{left, below}}) {
        quads_.vertices.push_back({{2.0f * static_cast<float>(x) / static_cast<float>(width_) - 1.0f,
                                    2.0f * static_cast<float>(y) / static_cast<float>(height_) - 1.0f, 0.0f},
                                   {0, 0, 0}});
      }
      for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) quads_.indices.push_back(first + k);
    }
  }
  if (quads_.indices.empty()) return;
  buffer_.upload(quads_);
  buffer_.draw();
}

bool scissor(const std::array<int, 4>& box) {
  if (box[2] <= 0 || box[3] <= 0) return false;
  glEnable(GL_SCISSOR_TEST);
  glScissor(box[0], box[1], box[2], box[3]);
  return true;
}

}  // namespace palpate::sim
