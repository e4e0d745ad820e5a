// Conditions of devices between memory and wire: which number means what stands here alone. Pure. Private to the messages.
#pragma once

#include <array>
#include <utility>

#include "palpate.pb.h"
#include "palpate/device/health.h"
#include "palpate/transport/internal/wire_table.h"

namespace palpate::transport {

using device::HealthCode;
using device::Severity;

inline constexpr std::array<std::pair<HealthCode, wire::HealthCode>, device::kHealthCodes> kWireHealthCodes{
    {{HealthCode::camera_silent, wire::HEALTH_CODE_CAMERA_SILENT},
     {HealthCode::camera_unfit, wire::HEALTH_CODE_CAMERA_UNFIT},
     {HealthCode::camera_lost, wire::HEALTH_CODE_CAMERA_LOST},
     {HealthCode::recording_ended, wire::HEALTH_CODE_RECORDING_ENDED},
     {HealthCode::image_size, wire::HEALTH_CODE_IMAGE_SIZE},
     {HealthCode::camera_clock, wire::HEALTH_CODE_CAMERA_CLOCK},
     {HealthCode::tracker_silent, wire::HEALTH_CODE_TRACKER_SILENT},
     {HealthCode::tracker_clock, wire::HEALTH_CODE_TRACKER_CLOCK},
     {HealthCode::tracker_blind, wire::HEALTH_CODE_TRACKER_BLIND},
     {HealthCode::landmarks_lost, wire::HEALTH_CODE_LANDMARKS_LOST},
     {HealthCode::right_eye_lost, wire::HEALTH_CODE_RIGHT_EYE_LOST},
     {HealthCode::board_lost, wire::HEALTH_CODE_BOARD_LOST},
     {HealthCode::arm_lost, wire::HEALTH_CODE_ARM_LOST},
     {HealthCode::arm_inconsistent, wire::HEALTH_CODE_ARM_INCONSISTENT},
     {HealthCode::arm_uncalibrated, wire::HEALTH_CODE_ARM_UNCALIBRATED},
     {HealthCode::arm_forces_off, wire::HEALTH_CODE_ARM_FORCES_OFF},
     {HealthCode::laboratory_silent, wire::HEALTH_CODE_LABORATORY_SILENT},
     {HealthCode::physics_server_gone, wire::HEALTH_CODE_PHYSICS_SERVER_GONE},
     {HealthCode::other_scene, wire::HEALTH_CODE_OTHER_SCENE},
     {HealthCode::other_rig, wire::HEALTH_CODE_OTHER_RIG}}};

inline constexpr std::array<std::pair<Severity, wire::HealthSeverity>, 3> kWireSeverities{
    {{Severity::notice, wire::HEALTH_SEVERITY_NOTICE},
     {Severity::warning, wire::HEALTH_SEVERITY_WARNING},
     {Severity::fault, wire::HEALTH_SEVERITY_FAULT}}};

}  // namespace palpate::transport
