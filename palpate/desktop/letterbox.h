// A picture in a window of another shape: as large as it fits, in the middle, its proportions kept.
//
// Pixels of the framebuffer, from its upper left corner, y down; edges lie at whole numbers. Picture pixels
// as everywhere: (0, 0) is the centre of the first pixel. Pure functions.
#pragma once

#include "palpate/device/camera_model.h"

namespace palpate::desktop {

struct Size {
  int width = 0, height = 0;
  bool operator==(const Size&) const = default;
};

struct Box {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Box&) const = default;
};

// Where the picture goes; an empty box where either size is empty.
Box letterbox(Size picture, Size framebuffer);

// The picture's pixel under a place in the framebuffer; beyond the box it lies beyond the picture.
device::Pixel picture_pixel(const Box& box, Size picture, const Eigen::Vector2d& place);

// Of a picture that is `eyes` pictures of one size side by side: the pixel in that eye's picture which a
// pixel of the whole lies in. Left of the first and right of the last it lies beyond theirs.
device::Pixel eye_pixel(const device::Pixel& pixel, Size picture, int eyes);

}  // namespace palpate::desktop
