#include "palpate/device/marker_names.h"

namespace palpate::device {

std::optional<MarkerId> marker_named(const std::string& name) {
  for (const auto marker : {MarkerId::tip_marker, MarkerId::camera_marker, MarkerId::pointer})
    if (name_of_marker(marker) == name) return marker;
  return std::nullopt;
}

std::string name_of_marker(MarkerId marker) {
  switch (marker) {
    case MarkerId::tip_marker:
      return "tip_marker";
    case MarkerId::camera_marker:
      return "camera_marker";
    case MarkerId::pointer:
      break;
  }
  return "pointer";
}

}  // namespace palpate::device
