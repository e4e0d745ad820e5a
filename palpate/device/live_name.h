// What markers are called where poses are sent or asked for by name: AToWorld maps coordinates of A to World.
#pragma once

#include <string>

#include "palpate/device/devices.h"

namespace palpate::device {

// "CameraMarkerToWorld" and so on.
inline std::string live_name(MarkerId marker) {
  switch (marker) {
    case MarkerId::tip_marker:
      return "TipMarkerToWorld";
    case MarkerId::camera_marker:
      return "CameraMarkerToWorld";
    case MarkerId::pointer:
      return "PointerToWorld";
  }
  return "";
}

}  // namespace palpate::device
