// The tables of a calibration, whoever wrote them; what they were taken for, and what was left out of them, is told.
#pragma once

#include <string>

#include "palpate/device/arm_samples.h"
#include "palpate/device/point_file.h"
#include "palpate/device/pose_file.h"

namespace palpate::tools::commands {

Expected<device::PoseFile> read_poses(const std::string& path, const device::PoseFileOptions& options = {});
Expected<device::PointFile> read_points(const std::string& path);
Expected<device::ArmSampleFile> read_arm_samples(const std::string& path);

}  // namespace palpate::tools::commands
