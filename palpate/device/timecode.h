// Time as a row of blocks that a camera can read: the instrument for the delay from light to light.
//
// The timecode is shown by a panel of lamps, or drawn on the screen: white, black, twelve blocks of a Gray
// code of the time in milliseconds, black, white. It begins anew every 4.096 s. A camera averages the blocks
// over its exposure, and that is no fault but the scale's vernier: a block that changed within the exposure
// is grey, and how grey says when. What is found is the exposure's middle, to a fraction of a millisecond,
// wherever the timecode is seen: in the camera's image, or in the finished picture. A screen shows it in a
// panel: a black margin, a white frame and a black border round it, so that it can be found in an image
// (timecode_finder.h); a screen that changes less often than each millisecond is read with timecode_log.h.
// Blocks are in light (0 ... 1, pictures hold its square root), pixels as CameraModel's. Pure functions, any
// thread. Sources: Gray (1953), US patent 2632058; bits averaged over an exposure are here the same for any
// code of period P: the share of the window in which they are 1.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/camera_model.h"
#include "palpate/time/instant.h"

namespace palpate::device {

inline constexpr int kTimecodeBits = 12, kTimecodeBlocks = kTimecodeBits + 4;
inline constexpr Duration kTimecodeTick = std::chrono::milliseconds(1);
inline constexpr Duration kTimecodeCycle = kTimecodeTick * (1 << kTimecodeBits);

using TimecodeLight = std::array<double, kTimecodeBlocks>;
using TimecodeBits = std::array<double, kTimecodeBits>;

// The panel, in blocks: timecode, margin, frame and border, the last three half a block wide all round.
inline constexpr double kPanelRim = 1.5, kPanelWide = kTimecodeBlocks + 2 * kPanelRim,
                        kPanelHigh = 1 + 2 * kPanelRim;
// Light of the panel at x, y blocks from its upper left corner; 0 beyond it.
double panel_light(double x, double y, const TimecodeLight& timecode);

// Mean light of each block from `middle` - exposure / 2 to `middle` + exposure / 2; times since any epoch.
// Exposure 0: the blocks as they stand at that moment.
TimecodeLight timecode_light(Duration middle, Duration exposure);

struct TimecodeReading {
  Duration middle{0};     // in 0 ... kTimecodeCycle
  double residual = 0.0;  // rms of the blocks, as a share of the contrast
};

// The moment whose blocks are these. Refused where black and white do not differ, or no moment's blocks are
// these (half hidden, out of focus, another exposure).
Expected<TimecodeReading> read_timecode(const TimecodeLight& blocks, Duration exposure);

// The twelve bits as shares of full light, between black and white as they are seen at the timecode's two
// ends (light that falls off along it does not matter). Refused where black and white do not differ.
Expected<TimecodeBits> timecode_bits(const TimecodeLight& blocks);

// What is accepted as the timecode: rms of the bits, as a share of the contrast.
inline constexpr double kMostTimecodeMisfit = 0.12;

// Light of each block in a picture (packed RGB, row 0 on top), from the middle half of the block: `corners`
// are the timecode's, seen in perspective, in order: first block's outer top, last block's, last's bottom,
// first's. Refused where the
// timecode reaches out of the picture or its blocks are smaller than 2 px.
Expected<TimecodeLight> timecode_blocks(std::span<const std::uint8_t> rgb, int width, int height,
                                        const std::array<Pixel, 4>& corners);

// The same for a timecode in its panel, light that falls off along it evened out by what the frame above and
// below each block shows of it.
Expected<TimecodeLight> panel_blocks(std::span<const std::uint8_t> rgb, int width, int height,
                                     const std::array<Pixel, 4>& corners);

// The projective map that takes (0, 0), (1, 0), (1, 1), (0, 1) to four corners of which no three lie in a
// line (Heckbert 1989, "Fundamentals of texture mapping and image warping", section 2.2.3).
Matrix3 from_unit_square(const std::array<Pixel, 4>& corners);

// Draws the panel as it stands at `now` into a picture, blocks of `block` x `block` px, its upper left corner
// at (left, top); for a screen that a camera looks at. What lies outside is left out.
void draw_panel(std::vector<std::uint8_t>& rgb, int width, int height, int left, int top, int block,
                Duration now);

// b - a on the timecode's circle of times: the smallest, of either sign.
Duration timecode_difference(Duration a, Duration b);

}  // namespace palpate::device
