// What a planar shadow's texture holds, read through a target of bytes.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/render/planar_shadow.h"

namespace palpate::render {

// Three bytes a texel: hidden by any body, by real ones, 0.
inline std::vector<std::uint8_t> texels_of(const PlanarShadow& shadow, const FullScreen& screen) {
  Program copy("copy", kFullScreen,
               "uniform sampler2D t; out vec4 c; void main() { c = vec4(texelFetch(t, "
               "ivec2(gl_FragCoord.xy), 0).rg, 0.0, 1.0); }");
  Target target(shadow.texture().width(), shadow.texture().height(), Format::rgb8, false);
  target.bind();
  shadow.texture().bind(0);
  copy.use().set("t", 0);
  screen.draw();
  std::vector<std::uint8_t> rgb;
  target.read_rgb(rgb);
  return rgb;
}

}  // namespace palpate::render
