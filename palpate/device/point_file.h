// Point lists as people bring them: CSV `x_mm,y_mm,z_mm` (or `_m`), an optional label column, more columns
// allowed. Read into metres. Errors: wrong use, with file and line.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/csv.h"
#include "palpate/core/expected.h"
#include "palpate/math/so3.h"

namespace palpate::device {

struct PointFile {
  std::string source, hash;
  std::vector<Vector3> points;      // m
  std::vector<std::string> labels;  // of label, name, landmark, point, corner, segment or id; empty without
  std::vector<double> weights;      // of a `weight` column; empty without
  CsvTable table;                   // all columns as read
};

Expected<PointFile> read_points(const std::filesystem::path& path);
Expected<PointFile> parse_points(std::string_view content, std::string source);

}  // namespace palpate::device
