// The test runtime's compositor: what an eye sees of the layers of a frame, pixel by pixel, on the processor.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "test_runtime_for_tests.h"

namespace palpate::headset {

struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;
};
struct Quat {
  double w = 1.0, x = 0.0, y = 0.0, z = 0.0;
};
struct Placed {  // b in a: p_a = turn p_b + at
  Quat turn;
  Vec3 at;
};
Vec3 turned(const Quat& q, const Vec3& v);
Vec3 turned_back(const Quat& q, const Vec3& v);
Placed chained(const Placed& a_b, const Placed& b_c);
Placed inverse(const Placed& a_b);

// As OpenGL gives it: four bytes a pixel, row 0 is the lowest.
struct LayerImage {
  int width = 0, height = 0;
  bool encoded = true;  // bytes are sRGB; else they are taken as linear, and encoded to be shown
  std::vector<std::uint8_t> rgba;
};

struct LayerPart {
  std::shared_ptr<const LayerImage> image;
  int x = 0, y = 0, width = 0, height = 0;
};

struct Layer {
  enum class Kind : std::uint8_t { quad, projection };
  Kind kind = Kind::quad;
  bool in_view = false;  // placed in VIEW and not in LOCAL
  bool blend = false;    // by the picture's own cover, colours multiplied by it
  // A quad:
  bool left = true, right = true;  // which eye sees it
  Placed place;
  double width = 0.0, height = 0.0;  // m
  LayerPart part;
  // A projection, for each eye: what was drawn from there, with the tangents of its edges.
  struct View {
    Placed place;
    double left = 0.0, right = 0.0, up = 0.0, down = 0.0;
    LayerPart part;
  };
  std::array<View, 2> views;
};

// `eye` in LOCAL, `head` in LOCAL. An eye of `pixels` across and down that sees half_view to each side.
EyePicture composite(const std::vector<Layer>& layers, int eye, const Placed& head,
                     const TestDisplay& display);

}  // namespace palpate::headset
