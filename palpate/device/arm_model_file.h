// A serial or a Cartesian arm in a TOML table: of an arm model's file, or of a rig's.
//
// One [[joint]] per joint, base first: a_mm, alpha_deg, d_mm, optional theta_offset_deg and range_deg (the
// corrected angles it reaches). tool_mm, optional: the tip in the last link's frame; tool_qwxyz, optional: the
// stylus in it. Of a Cartesian arm range_mm: lowest and highest place along x, y and z; optional correction_mm, the
// 24 numbers of place_correction.h. Complaints go to the table, with file and line.
#pragma once

#include <string>

#include "palpate/core/toml.h"
#include "palpate/device/arm_model.h"

namespace palpate::device {

// Makes `model` the chain that the table holds.
void read_dh_chain(const TomlTable& table, ArmModel& model);

// Makes `model` the Cartesian arm that the table holds.
void read_cartesian(const TomlTable& table, ArmModel& model);
// type, range_mm and, where anything is corrected, correction_mm, a line each.
std::string cartesian_text(const ArmModel& model);

// tool_mm and tool_qwxyz, a line each; to stand in the table itself, before its [[joint]] tables.
std::string tool_text(const ArmModel& model);
// The [[joint]] tables; `table` is their name from the top: "arm.joint".
std::string dh_joints_text(const ArmModel& model, const std::string& table);

}  // namespace palpate::device
