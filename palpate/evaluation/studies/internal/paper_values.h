// What the paper states about its own calibration, in its text; its plots' single points are not given there.
//
// Source: Bianchi, Knoerlein, Szekely, Harders (2006), "High precision augmented reality haptics"; sections
// as noted. Millimetres.
#pragma once

#include "palpate/core/json.h"

namespace palpate::evaluation::studies::paper {

inline constexpr double kTrackerRms_mm = 0.2;     // 3: OPTOTRAK 3020 at 2.25 m
inline constexpr double kFullSphere_mm = 0.05;    // 4.2.2, Figure 4: centre error is lower than this
inline constexpr double kQuarterSphere_mm = 0.2;  // 4.2.2: centre error up to this
inline constexpr double kTipMotionLow_mm = 1.0;   // 4.2.2: the stylus moves about 1-2 mm
inline constexpr double kTipMotionHigh_mm = 2.0;
inline constexpr double kPivotGlobal_mm = 1.0;  // 4.2.2: global error smaller than this
inline constexpr double kBefore_mm = 3.0;       // 4.4.2, Figure 7: from 3 ...
inline constexpr double kAfter_mm = 1.3;        // ... to 1.3 mm
inline constexpr double kEnoughPoints = 30;     // 4.4.2: a minimum of 30 points can be used

}  // namespace palpate::evaluation::studies::paper
