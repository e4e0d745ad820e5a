// Poses, points and samples of arms for calibrations, from tables of this program (device/pose_file.h, point_file.h) and from files of others.
//
// Errors: as device::read_poses(), device::read_points() and formats::read(). Any thread.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/device/arm_samples.h"
#include "palpate/device/point_file.h"
#include "palpate/device/pose_file.h"

namespace palpate::formats {

// What was read is of another program, or its cells are not separated by commas.
bool is_of_others(std::string_view content);

struct PoseTable {
  device::PoseFile file;
  std::string form;          // "a TUM trajectory"; empty: a table of this program
  std::size_t left_out = 0;  // rows in which the body was hidden
};

// options.transform names the body, too, where a file holds several.
Expected<PoseTable> read_poses(const std::filesystem::path& path,
                               const device::PoseFileOptions& options = {});

struct PointTable {
  device::PointFile file;
  std::string form;  // with the frame it is in: "markups of 3D Slicer (.fcsv): RAS, turned into LPS, mm"
};
Expected<PointTable> read_points(const std::filesystem::path& path);

// This program's columns (device/arm_samples.h), whatever separates them.
Expected<device::ArmSampleFile> read_arm_samples(const std::filesystem::path& path);

}  // namespace palpate::formats
