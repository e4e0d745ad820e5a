// Units at the border. Inside everything is SI and radians; these names mark each place where that changes.
#pragma once

#include <numbers>

namespace palpate {

inline constexpr double kMillimetresPerMetre = 1000.0;
inline constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

constexpr double metres_from_mm(double mm) { return mm / kMillimetresPerMetre; }
constexpr double mm_from_metres(double m) { return m * kMillimetresPerMetre; }
constexpr double radians_from_degrees(double degrees) { return degrees / kDegreesPerRadian; }
constexpr double degrees_from_radians(double radians) { return radians * kDegreesPerRadian; }

}  // namespace palpate
