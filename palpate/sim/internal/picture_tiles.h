// The camera's picture cut into squares, and which of them a flat rectangle reaches or fills.
//
// A software renderer pays for every pixel it looks at: what is drawn tile by tile costs what it covers, and
// the inside of a surface can do without what only its edge needs. Thread: the OpenGL context's.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "palpate/math/so3.h"
#include "palpate/render/mesh_buffer.h"
#include "palpate/sim/lens_rays.h"

namespace palpate::sim {

enum class TileCover : std::uint8_t { none, part, whole };

class PictureTiles {
 public:
  // `rays` of each pixel, row by row.
  PictureTiles(int width, int height, const std::vector<Eigen::Vector2f>& rays);

  std::size_t count() const { return corners_.size(); }
  // Of each tile. `to_plane` maps a ray (x, y, 1) to (x, y, 1) / depth, x and y in metres along the plane's
  // axes; the rectangle reaches from low to high. Never `none` or `whole` where that might be wrong.
  std::vector<TileCover> cover(const Matrix3& to_plane, const Eigen::Vector2d& low,
                               const Eigen::Vector2d& high) const;
  // Draws the tiles marked; the program's vertex shader is kTileVertex.
  void draw(const std::vector<char>& wanted);

 private:
  static constexpr int kSide = 32;  // px
  int width_, height_, columns_;
  std::vector<std::array<Eigen::Vector2d, 4>> corners_;  // rays
  render::MeshBuffer buffer_;
  render::ShadedMesh quads_;
};

// Limits drawing to a box of pixels (x, y, width, height); false where it is empty.
bool scissor(const std::array<int, 4>& box);

}  // namespace palpate::sim
