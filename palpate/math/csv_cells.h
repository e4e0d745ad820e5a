// Cells of the raw files' rows: numbers with twelve significant digits, poses as place and quaternion.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "palpate/core/csv.h"
#include "palpate/math/pose.h"

namespace palpate::inline math {

using Cells = std::vector<std::string>;

inline void put(Cells& row, double value) { row.push_back(number_text(value)); }
inline void put(Cells& row, const Vector3& v) {
  for (int i = 0; i < 3; ++i) put(row, v[i]);
}
template <typename A, typename B>
void put(Cells& row, const Pose<A, B>& X) {
  put(row, X.translation);
  put(row, X.rotation.w());
  put(row, X.rotation.vec());
}
inline void put(Cells& row, const std::optional<double>& value) {
  row.push_back(value ? number_text(*value) : "");
}

// Names of a pose's cells: cam_x_m ... cam_qz for "cam".
inline Cells pose_columns(const std::string& of) {
  Cells names;
  for (const char* part : {"_x_m", "_y_m", "_z_m", "_qw", "_qx", "_qy", "_qz"}) names.push_back(of + part);
  return names;
}
inline Cells point_columns(const std::string& of) { return {of + "_x_m", of + "_y_m", of + "_z_m"}; }

inline Cells joined(std::initializer_list<Cells> parts) {
  Cells all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace palpate::inline math
