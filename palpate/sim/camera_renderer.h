// What the simulated camera sees: a picture of the real (simulated) world through its lens, with noise.
//
// Truth goes in, pixels come out, and nothing else leaves. Each pixel's ray is found by inverting the lens
// model exactly, and flat things (table, wall, dots, board) are intersected with that ray, so their places in
// the picture agree with CameraModel::project to far below a tenth of a pixel. The arm is drawn as triangles
// and bent through the lens. Deterministic to the bit on one version of Mesa. Throws where no OpenGL is to be
// had. Thread: constructed, used and destroyed on one thread.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "palpate/sim/true_view.h"

namespace palpate::sim {

class CameraRenderer {
 public:
  CameraRenderer();
  ~CameraRenderer();
  // Packed RGB, row 0 on top, lens.width x lens.height.
  void render(const TrueView& view, std::vector<std::uint8_t>& rgb);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::sim
