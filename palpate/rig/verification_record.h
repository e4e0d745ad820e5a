// What a rig keeps of a verification (palpate verify): how good it was on a day.
//
// Figures in the units of their names, as people read them: mm, px, ms. Values.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate::rig {

struct VerifiedFigure {
  std::string name;  // with its unit: "arm_mm"; letters, digits and _
  // The rig's own error then and its 95 % interval; what the calibration had promised it to stay below; the
  // differences that were observed, and what these were to stay below.
  double error = 0.0, low = 0.0, high = 0.0, promised = 0.0, seen = 0.0, seen_most = 0.0;
};

struct VerificationRecord {
  std::string date;  // ISO 8601, UTC
  std::string form;  // "full" or "quick"
  bool holds = false;
  std::vector<std::string> changed;  // what was found to have moved, by name
  std::vector<VerifiedFigure> figures;
};

// A rig file keeps so many, the newest.
inline constexpr std::size_t kVerificationsKept = 30;

}  // namespace palpate::rig
