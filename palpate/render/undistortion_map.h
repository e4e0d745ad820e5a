// The camera's image with its lens undone, on the processor: what a software renderer does several times slower.
//
// A pixel of the picture shows where CameraModel::distort says it lies in the image, interpolated linearly between the four
// pixels there, to 1/256 of a pixel; beyond the rim the image's last pixel goes on. Bytes are interpolated as they are. The
// same place for the same camera, to the bit. Values; undo() may run on several threads of its own.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "palpate/device/camera_model.h"

namespace palpate::render {

class UndistortionMap {
 public:
  UndistortionMap() = default;
  explicit UndistortionMap(const device::CameraModel& camera);

  bool is_of(const device::CameraModel& camera) const;
  // Packed RGB of the camera's size; `picture` is where row 0 begins, rows are `stride` pixels apart.
  void undo(std::span<const std::uint8_t> image, std::uint8_t* picture, int stride) const;

 private:
  struct Source {
    std::uint32_t first;         // byte of the left of the upper two
    std::uint16_t right, below;  // shares of 256
  };
  void undo_row(std::span<const std::uint8_t> image, int row, std::uint8_t* picture) const;

  device::CameraModel camera_{};
  std::vector<Source> sources_;
};

}  // namespace palpate::render
