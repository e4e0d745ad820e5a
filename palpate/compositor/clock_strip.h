// Time as a row of blocks that a camera can read: the instrument for the delay from light to light.
//
// The strip is shown by a panel of lamps, or drawn on the screen: white, black, twelve blocks of a Gray code
// of the time in milliseconds, black, white. It begins anew every 4.096 s. A camera averages the blocks over
// its exposure, and that is no fault but the scale's vernier: a block that changed within the exposure is
// grey, and how grey says when. What is found is the exposure's middle, to a fraction of a millisecond,
// wherever the strip is seen: in the camera's image, or in the finished picture. Blocks are in light (0 ...
// 1, pictures hold its square root), pixels as CameraModel's. Pure functions, any thread. Sources: Gray
// (1953), US patent 2632058; bits averaged over an exposure are here the same for any code of period P: the
// share of the window in which they are 1.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/model/camera.h"
#include "palpate/time/instant.h"

namespace palpate {

inline constexpr int kStripBits = 12, kStripBlocks = kStripBits + 4;
inline constexpr Duration kStripTick = std::chrono::milliseconds(1);
inline constexpr Duration kStripCycle = kStripTick * (1 << kStripBits);

using StripLight = std::array<double, kStripBlocks>;

// Mean light of each block from `middle` - exposure / 2 to `middle` + exposure / 2; times since any epoch.
// Exposure 0: the blocks as they stand at that moment.
StripLight strip_light(Duration middle, Duration exposure);

struct StripReading {
  Duration middle{0};     // in 0 ... kStripCycle
  double residual = 0.0;  // rms of the blocks, as a share of the contrast
};

// The moment whose blocks are these. Refused where black and white do not differ, or no moment's blocks are
// these (half hidden, out of focus, another exposure).
Expected<StripReading> read_strip(const StripLight& blocks, Duration exposure);

// Light of each block in a picture (packed RGB, row 0 on top), from the middle half of the block: `corners`
// are the strip's, in order: first block's outer top, last block's, last's bottom, first's. Refused where the
// strip reaches out of the picture or its blocks are smaller than 2 px.
Expected<StripLight> strip_blocks(std::span<const std::uint8_t> rgb, int width, int height,
                                  const std::array<Pixel, 4>& corners);

// Draws the strip as it stands at `now` into a picture, blocks of `block` x `block` px from (left, top) on,
// with a black margin of half a block; for a screen that a camera looks at. What lies outside is left out.
void draw_strip(std::vector<std::uint8_t>& rgb, int width, int height, int left, int top, int block,
                Duration now);

// b - a on the strip's circle of times: the smallest, of either sign.
Duration strip_difference(Duration a, Duration b);

}  // namespace palpate
