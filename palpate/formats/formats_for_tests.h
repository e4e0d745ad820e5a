// What tests of the forms share: contents read as a kind, refusals, one pose that every form of poses has.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "palpate/formats/read.h"

namespace palpate::formats {

template <typename Kind>
Kind read_as(std::string_view content, const ReadOptions& options = {}) {
  const auto read = parse(content, "file", options);
  if (!read) {
    ADD_FAILURE() << read.error().message;
    return {};
  }
  const auto* value = std::get_if<Kind>(&read->value);
  if (value == nullptr) {
    ADD_FAILURE() << "another kind: " << read->form;
    return {};
  }
  return *value;
}

inline std::string refusal(std::string_view content, const ReadOptions& options = {}) {
  const auto read = parse(content, "file", options);
  if (!read) return read.error().message;
  ADD_FAILURE() << "accepted as " << read->form;
  return {};
}

inline bool holds(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

inline const Vector3 kPlace(0.1, -0.2, 0.3);
inline const Quaternion kTurn(0.5, 0.5, -0.5, 0.5);

inline void expect_pose(const device::StampedPose& pose, double time_s) {
  EXPECT_EQ(pose.time_s, time_s);
  EXPECT_LT((pose.translation - kPlace).norm(), 1e-12);
  EXPECT_LT(pose.rotation.angularDistance(kTurn), 1e-12);
}

inline constexpr const char* kLens =
    "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   "
    "cols: 3\n   "
    "dt: d\n   data: [ 500., 0., 320., 0., 510., 240., 0., 0., 1. ]\ndistortion_coefficients: "
    "!!opencv-matrix\n   "
    "rows: 1\n   cols: N\n   dt: d\n   data: [ K ]\n";

inline std::string lens_with(const std::string& coefficients) {
  std::string text = kLens;
  return text.replace(text.find('K'), 1, coefficients);
}

}  // namespace palpate::formats
