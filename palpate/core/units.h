// Units at the border. Inside everything is SI and radians; these names mark each place where that changes.
#pragma once

#include <numbers>

namespace palpate::inline core {

inline constexpr double kMillimetresPerMetre = 1000.0;
inline constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

// Nothing that is calibrated or read from a file lies further away or later, or has turned further: beyond it
// stands a mistaken unit.
inline constexpr double kFarthestPlace = 1e8;  // m
inline constexpr double kLatestTime = 1e11;    // s, from any origin (the year 5138 from 1970)
inline constexpr double kLargestAngle = 1e4;   // rad

constexpr double metres_from_mm(double mm) { return mm / kMillimetresPerMetre; }
constexpr double mm_from_metres(double m) { return m * kMillimetresPerMetre; }
constexpr double radians_from_degrees(double degrees) { return degrees / kDegreesPerRadian; }
constexpr double degrees_from_radians(double radians) { return radians * kDegreesPerRadian; }

}  // namespace palpate::inline core
