// Finds the timecode's panel in a camera's image, wherever a screen shows it: at a slant, out of focus,
// partly lit, among other things.
//
// The panel's white frame is a closed bright ring between dark ones. Pixels brighter than their
// neighbourhood (Bradley and Roth 2007, "Adaptive thresholding using the integral image") are joined to
// regions; a region's outermost points along the two diagonals are a frame's corners where it is one, which
// is looked at along the frame and the margin inside; lines through the middle of its brightness say where it
// is to a fraction of a pixel. The camera is held upright: rolled by less than 35 degrees against the screen.
// Pixels as CameraModel's. Pure function, any thread; some milliseconds for a megapixel.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "palpate/device/camera_model.h"

namespace palpate::evaluation {

// Corners of a timecode, as timecode_blocks() wants them.
using TimecodeCorners = std::array<device::Pixel, 4>;

// Part of a picture: first column and row, and those after the last.
struct PictureArea {
  int left = 0, top = 0, right = 0, bottom = 0;
};

// All that look like the panel, the largest first (a screen that shows the camera's picture shows a smaller
// one within); only in a part of the picture where one is given. Packed RGB, row 0 on top.
std::vector<TimecodeCorners> find_timecodes(std::span<const std::uint8_t> rgb, int width, int height,
                                            const std::optional<PictureArea>& area = {});

}  // namespace palpate::evaluation
