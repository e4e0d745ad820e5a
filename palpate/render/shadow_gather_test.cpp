#include "palpate/render/shadow_gather.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "palpate/core/random.h"
#include "palpate/render/arm_body.h"
#include "palpate/render/context.h"
#include "palpate/render/planar_shadow.h"
#include "palpate/render/shadow_texels_for_tests.h"

namespace palpate::render {
namespace {

std::vector<std::uint8_t> random_tiles(int size, std::uint64_t seed) {
  Random random(seed, "tiles");
  std::vector<std::uint8_t> tiles(static_cast<std::size_t>(2 * 16 * size * size));
  for (auto& texel : tiles) texel = random.chance(0.4) ? 255 : 0;
  return tiles;
}

// Texel by texel, with the shader's own words: a look-up half a texel beside the middle is the mean of four.
TEST(ShadowGather, IsTheMeanOfTheSamplesSoftenedOverNeighbours) {
  const int size = 19;
  const auto tiles = random_tiles(size, 5);
  std::vector<std::uint8_t> result;
  gather_tiles(tiles, size, result);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      double any = 0.0, real = 0.0;
      for (int i = 0; i < 16; ++i) {
        double sum[2] = {0.0, 0.0};
        for (const int dx : {0, (i & 1) == 0 ? 1 : -1})
          for (const int dy : {0, (i & 2) == 0 ? 1 : -1}) {
            const int u = i % 4 * size + std::clamp(x + dx, 0, size - 1),
                      v = i / 4 * size + std::clamp(y + dy, 0, size - 1);
            for (int c = 0; c < 2; ++c)
              sum[c] += tiles[static_cast<std::size_t>(2 * (v * 4 * size + u) + c)] / 4.0;
          }
        any += std::max(sum[0], sum[1]);
        real += sum[1];
      }
      const auto at = static_cast<std::size_t>(2 * (y * size + x));
      EXPECT_NEAR(result[at], any / 16.0, 0.51);
      EXPECT_NEAR(result[at + 1], real / 16.0, 0.51);
    }
}

TEST(ShadowGather, WrongSizesAreRefused) {
  std::vector<std::uint8_t> result;
  EXPECT_THROW(gather_tiles(random_tiles(8, 1), 9, result), std::invalid_argument);
  EXPECT_THROW(gather_tiles({}, 0, result), std::invalid_argument);
}

TEST(ShadowGather, ProcessorAndCardAgreeToALevel) {
  const auto context = Context::required();
  const FullScreen screen;
  const MeshBuffer ball(scene::sphere_mesh(0.03));
  device::RoomLight light;
  light.lamp = {0.3, 1.5, 0.2};
  const ShadowReceiver table{{-0.5, 0.0, 0.5}, Vector3::UnitX(), -Vector3::UnitZ(), 1.0, 1.0};
  std::vector<ShadowCaster> casters(2, ShadowCaster{&ball});
  casters[0].X_world_mesh.topRightCorner<3, 1>() = Vector3f(0.05f, 0.1f, -0.1f);
  casters[1].X_world_mesh.topRightCorner<3, 1>() = Vector3f(0.08f, 0.05f, -0.12f);
  casters[1].real = true;
  std::vector<std::uint8_t> drawn[2];
  for (const bool by_processor : {false, true}) {
    PlanarShadow shadow(96, by_processor);
    ASSERT_TRUE(shadow.draw(casters, table, light, screen));
    drawn[by_processor] = texels_of(shadow, screen);
  }
  int dark = 0;
  for (std::size_t i = 0; i < drawn[0].size(); ++i) {
    EXPECT_NEAR(drawn[0][i], drawn[1][i], 1) << i;
    dark += drawn[0][i] > 100;
  }
  EXPECT_GT(dark, 1000);
}

}  // namespace
}  // namespace palpate::render
