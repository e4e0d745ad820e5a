#include "palpate/desktop/letterbox.h"

#include <algorithm>
#include <cmath>

namespace palpate::desktop {

Box letterbox(Size picture, Size framebuffer) {
  if (picture.width <= 0 || picture.height <= 0 || framebuffer.width <= 0 || framebuffer.height <= 0)
    return {};
  const double scale = std::min(static_cast<double>(framebuffer.width) / picture.width,
                                static_cast<double>(framebuffer.height) / picture.height);
  // At least a pixel, however thin somebody draws the window.
  const int width = std::max(1, static_cast<int>(std::lround(scale * picture.width)));
  const int height = std::max(1, static_cast<int>(std::lround(scale * picture.height)));
  return {(framebuffer.width - width) / 2, (framebuffer.height - height) / 2, width, height};
}

device::Pixel picture_pixel(const Box& box, Size picture, const Eigen::Vector2d& place) {
  if (box.width <= 0 || box.height <= 0) return device::Pixel::Zero();
  return {(place.x() - box.x) / box.width * picture.width - 0.5,
          (place.y() - box.y) / box.height * picture.height - 0.5};
}

device::Pixel eye_pixel(const device::Pixel& pixel, Size picture, int eyes) {
  const double width = static_cast<double>(picture.width) / std::max(1, eyes);
  if (eyes <= 1 || width <= 0.0) return pixel;
  const double eye = std::clamp(std::floor((pixel.x() + 0.5) / width), 0.0, eyes - 1.0);
  return {pixel.x() - eye * width, pixel.y()};
}

}  // namespace palpate::desktop
