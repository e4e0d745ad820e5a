#include "compositor.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace palpate::headset {
namespace {

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct Sample {
  std::array<double, 4> rgba{};  // 0 ... 255, as they are shown
};

double shown(double value, bool encoded) {
  if (encoded) return value;
  const double linear = value / 255.0;
  return 255.0 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055);
}

// At (u, v) in [0, 1], from the lower left corner of the part; between pixel centres in straight lines.
Sample sample(const LayerPart& part, double u, double v) {
  const LayerImage& image = *part.image;
  const double x = std::clamp(u * part.width - 0.5, 0.0, part.width - 1.0);
  const double y = std::clamp(v * part.height - 0.5, 0.0, part.height - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, part.width - 1), y1 = std::min(y0 + 1, part.height - 1);
  const auto byte = [&](int column, int row, int channel) {
    const auto index = (static_cast<std::size_t>(part.y + row) * static_cast<std::size_t>(image.width) +
                        static_cast<std::size_t>(part.x + column)) *
                           4 +
                       static_cast<std::size_t>(channel);
    return static_cast<double>(image.rgba[index]);
  };
  Sample result;
  for (int c = 0; c < 4; ++c) {
    const double low = byte(x0, y0, c) + (x - x0) * (byte(x1, y0, c) - byte(x0, y0, c));
    const double high = byte(x0, y1, c) + (x - x0) * (byte(x1, y1, c) - byte(x0, y1, c));
    const double value = low + (y - y0) * (high - low);
    result.rgba[static_cast<std::size_t>(c)] = c == 3 ? value : shown(value, image.encoded);
  }
  return result;
}

// Where the ray meets the front of the quad.
std::optional<Sample> of_quad(const Layer& layer, const Placed& in_local, const Vec3& from, const Vec3& ray) {
  const Vec3 apart{from.x - in_local.at.x, from.y - in_local.at.y, from.z - in_local.at.z};
  const Vec3 origin = turned_back(in_local.turn, apart), way = turned_back(in_local.turn, ray);
  if (origin.z <= 0.0 || way.z >= 0.0) return std::nullopt;  // seen from the back, or never met
  const double t = -origin.z / way.z;
  const double u = (origin.x + t * way.x) / layer.width + 0.5;
  const double v = (origin.y + t * way.y) / layer.height + 0.5;
  if (u < 0.0 || u > 1.0 || v < 0.0 || v > 1.0) return std::nullopt;
  return sample(layer.part, u, v);
}

// Infinitely far: by the ray's direction alone.
std::optional<Sample> of_projection(const Layer::View& view, const Placed& in_local, const Vec3& ray) {
  const Vec3 way = turned_back(in_local.turn, ray);
  if (way.z >= 0.0) return std::nullopt;
  const double u = (way.x / -way.z - view.left) / (view.right - view.left);
  const double v = (way.y / -way.z - view.down) / (view.up - view.down);
  if (u < 0.0 || u > 1.0 || v < 0.0 || v > 1.0) return std::nullopt;
  return sample(view.part, u, v);
}

std::optional<Sample> look(const Layer& layer, int eye, const Placed& head, const Vec3& from,
                           const Vec3& ray) {
  const auto in_local = [&](const Placed& place) { return layer.in_view ? chained(head, place) : place; };
  if (layer.kind == Layer::Kind::projection) {
    const Layer::View& view = layer.views[static_cast<std::size_t>(eye)];
    return of_projection(view, in_local(view.place), ray);
  }
  if (eye == 0 ? !layer.left : !layer.right) return std::nullopt;
  return of_quad(layer, in_local(layer.place), from, ray);
}

}  // namespace

Vec3 turned(const Quat& q, const Vec3& v) {
  const Vec3 axis{q.x, q.y, q.z};
  const Vec3 once = cross(axis, v);
  const Vec3 twice = cross(axis, once);
  return {v.x + 2.0 * (q.w * once.x + twice.x), v.y + 2.0 * (q.w * once.y + twice.y),
          v.z + 2.0 * (q.w * once.z + twice.z)};
}

Vec3 turned_back(const Quat& q, const Vec3& v) { return turned({q.w, -q.x, -q.y, -q.z}, v); }

Placed chained(const Placed& a_b, const Placed& b_c) {
  const Quat &p = a_b.turn, &q = b_c.turn;
  const Quat turn{
      p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z, p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y,
      p.w * q.y - p.x * q.z + p.y * q.w + p.z * q.x, p.w * q.z + p.x * q.y - p.y * q.x + p.z * q.w};
  const Vec3 at = turned(p, b_c.at);
  return {turn, {a_b.at.x + at.x, a_b.at.y + at.y, a_b.at.z + at.z}};
}

Placed inverse(const Placed& a_b) {
  const Vec3 back = turned_back(a_b.turn, a_b.at);
  return {{a_b.turn.w, -a_b.turn.x, -a_b.turn.y, -a_b.turn.z}, {-back.x, -back.y, -back.z}};
}

EyePicture composite(const std::vector<Layer>& layers, int eye, const Placed& head,
                     const TestDisplay& display) {
  const int n = display.pixels;
  const double edge = std::tan(display.half_view);
  const Placed eye_in_head{{}, {(eye == 0 ? -0.5 : 0.5) * display.eye_distance, 0.0, 0.0}};
  const Vec3 from = chained(head, eye_in_head).at;
  EyePicture picture{
      n, n, std::vector<std::uint8_t>(static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * 3)};
  std::size_t at = 0;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column, at += 3) {
      const Vec3 in_eye{edge * (2.0 * (column + 0.5) / n - 1.0), edge * (1.0 - 2.0 * (row + 0.5) / n), -1.0};
      const Vec3 ray = turned(head.turn, in_eye);
      std::array<double, 3> colour{};
      for (const Layer& layer : layers) {
        const auto met = look(layer, eye, head, from, ray);
        if (!met) continue;
        const double through = layer.blend ? 1.0 - met->rgba[3] / 255.0 : 0.0;
        for (std::size_t c = 0; c < 3; ++c) colour[c] = met->rgba[c] + through * colour[c];
      }
      for (std::size_t c = 0; c < 3; ++c)
        picture.rgb[at + c] = static_cast<std::uint8_t>(std::clamp(std::lround(colour[c]), 0L, 255L));
    }
  }
  return picture;
}

}  // namespace palpate::headset
