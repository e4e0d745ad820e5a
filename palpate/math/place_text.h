// A place in a message: "(12.0, -3.4, 108.1) mm". Any thread.
#pragma once

#include <fmt/format.h>

#include <string>

#include "palpate/core/units.h"
#include "palpate/math/so3.h"

namespace palpate::inline math {

inline std::string place_text_mm(const Vector3& place, int digits = 1) {  // m
  const Vector3 mm = place * kMillimetresPerMetre;
  return fmt::format("({:.{}f}, {:.{}f}, {:.{}f}) mm", mm.x(), digits, mm.y(), digits, mm.z(), digits);
}

}  // namespace palpate::inline math
