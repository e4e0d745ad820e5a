// A ChArUco board on a desk, seen through a lens: drawn from a known truth, for tests only.
//
// Rays are undistorted once for a lens, rays x rays a pixel. Noise lies on top; something dark may cover a
// part of the sheet.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/vision/charuco.h"

namespace palpate::vision::synthetic {

class CharucoCamera {
 public:
  CharucoCamera(const device::CameraModel& camera, const device::CharucoBoard& board, int rays = 3)
      : board_(board), side_(rays), per_pixel_(static_cast<std::size_t>(rays * rays)) {
    for (int id = 0; id < board.markers(); ++id) bits_.push_back(charuco_bits(board.dictionary, id));
    id_of_.assign(static_cast<std::size_t>(board.columns * board.rows), -1);
    int id = 0;
    for (int square = 0; square < board.columns * board.rows; ++square)
      if ((square / board.columns + square % board.columns) % 2 == 1)
        id_of_[static_cast<std::size_t>(square)] = id++;
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u)
        for (int k = 0; k < rays * rays; ++k) {
          const double du = (k % side_ + 0.5) / side_ - 0.5, dv = (k / side_ + 0.5) / side_ - 0.5;
          const auto n =
              camera.undistort({(u + du - camera.cx) / camera.fx, (v + dv - camera.cy) / camera.fy});
          rays_.push_back(n ? Eigen::Vector2f(n->cast<float>()) : Eigen::Vector2f(1e3f, 1e3f));
        }
  }

  // Board coordinates, m, that something dark covers.
  struct Cover {
    double left, right, above, below;
  };

  std::vector<std::uint8_t> grey(const Pose<CameraOptical, Board>& X, double noise_sd, Random& random,
                                 const std::optional<Cover>& cover = {}) const {
    const auto inverse = X.inverse();
    const Matrix3 R = inverse.matrix();
    std::vector<std::uint8_t> picture;
    picture.reserve(rays_.size() / (per_pixel_));
    for (std::size_t i = 0; i < rays_.size(); i += per_pixel_) {
      double sum = 0.0;
      for (std::size_t k = i; k < i + per_pixel_; ++k) {
        const Vector3 ray =
            R * Vector3(static_cast<double>(rays_[k].x()), static_cast<double>(rays_[k].y()), 1.0);
        const double along = -inverse.translation.z() / ray.z();
        sum += along > 0.0 ? shade(inverse.translation + along * ray, cover) : kRoom;
      }
      const double value =
          sum / static_cast<double>(per_pixel_) + (noise_sd > 0.0 ? random.normal(noise_sd) : 0.0);
      picture.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)));
    }
    return picture;
  }

 private:
  static constexpr double kRoom = 90.0, kPaper = 215.0, kInk = 35.0, kHand = 70.0;

  double shade(const Vector3& p, const std::optional<Cover>& cover) const {
    if (cover && p.x() > cover->left && p.x() < cover->right && p.y() > cover->above && p.y() < cover->below)
      return kHand;
    const double margin = 0.4 * board_.square;
    const double x = p.x() + board_.square, y = p.y() + board_.square;
    const double width = board_.columns * board_.square, height = board_.rows * board_.square;
    if (x < -margin || y < -margin || x > width + margin || y > height + margin) {
      // A desk with grain: nothing that looks like a marker.
      return kRoom + 9.0 * std::sin(310.0 * p.x() + 60.0 * p.y());
    }
    if (x < 0.0 || y < 0.0 || x >= width || y >= height) return kPaper;
    const int column = static_cast<int>(x / board_.square), row = static_cast<int>(y / board_.square);
    const int id = id_of_[static_cast<std::size_t>(row * board_.columns + column)];
    if (id < 0) return kInk;
    const double inset = 0.5 * (board_.square - board_.marker);
    const double mx = x - column * board_.square - inset, my = y - row * board_.square - inset;
    if (mx < 0.0 || my < 0.0 || mx >= board_.marker || my >= board_.marker) return kPaper;
    const auto& bits = bits_[static_cast<std::size_t>(id)];
    const double cell = board_.marker / static_cast<double>(bits.size());
    return bits[static_cast<std::size_t>(my / cell)][static_cast<std::size_t>(mx / cell)] ? kInk : kPaper;
  }

  device::CharucoBoard board_;
  int side_;
  std::size_t per_pixel_;
  std::vector<std::vector<std::vector<bool>>> bits_;
  std::vector<int> id_of_;
  std::vector<Eigen::Vector2f> rays_;
};

}  // namespace palpate::vision::synthetic
