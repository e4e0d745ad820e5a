// The fields of a world file: sections, keys, units and ranges, once for reading and for writing.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "palpate/core/toml.h"
#include "palpate/core/units.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::sim::config {

inline constexpr double kMm = 1e-3, kMs = 1e-3, kDeg = 1.0 / kDegreesPerRadian, kSi = 1.0;
inline constexpr NumberRange kShare{0.0, 1.0};
inline constexpr NumberRange kRates{1.0, 1e6};
inline constexpr NumberRange kFaultTimes{0.0, 1e6};
// The laboratory's; all others are of applications.
inline constexpr std::array kSections = {
    "world", "clocks", "tracker", "tip_marker", "camera_marker", "pointer", "arm",   "arm_faults",
    "hand",  "camera", "head",    "scene",      "display",       "faults",  "knock", "player"};

inline bool is_laboratorys(std::string_view section) {
  return std::find(kSections.begin(), kSections.end(), section) != kSections.end();
}

// One list of all fields serves reading and writing: `V` is Reader or Writer, `W` the world (const for
// writing). number(key, field, unit, range): field = value in the file times unit.
template <typename V, typename W>
void visit_tracker(V& v, W& w) {
  v.section("world");
  v.vector("gravity_m_s2", w.gravity, kSi);
  v.number("rate_hz", w.rate_hz, kSi, {500.0, 100000.0});

  v.section("clocks");
  v.clock("arm", w.clocks.arm);
  v.clock("tracker", w.clocks.tracker);
  v.clock("camera", w.clocks.camera);
  v.clock("graphics_host", w.clocks.graphics_host);

  v.section("tracker");
  v.rows("camera_positions_m", w.tracker.cameras, kSi);
  v.vector("look_at_m", w.tracker.look_at, kSi);
  v.number("optimal_distance_m", w.tracker.optimal_distance, kSi, {0.1, 100.0});
  v.number("rate_hz", w.tracker.rate_hz, kSi, kRates);
  v.number("latency_ms", w.tracker.latency_s, kMs, {0.0, 1e4});
  v.number("led_white_rms_mm", w.tracker.white_rms, kMm, kNotNegative);
  v.number("led_bias_rms_mm", w.tracker.bias_rms, kMm, kNotNegative);
  v.number("led_bias_correlation_m", w.tracker.bias_correlation, kSi, {1e-3, 1e3});
  v.number("dropout_probability", w.tracker.dropout, kSi, kShare);
  v.number("max_led_angle_deg", w.tracker.max_led_angle, kDeg, {0.0, 180.0});

  v.section("tip_marker");
  v.rows("leds_mm", w.tip_marker.leds, kMm);
  v.vector("tip_mm", w.tip_marker.tip, kMm);
  v.number("tip_mount_sd_mm", w.tip_marker.mount_sd, kMm, kNotNegative);

  v.section("camera_marker");
  v.rows("leds_mm", w.camera_marker.leds, kMm);
  v.vector("camera_translation_mm", w.camera_marker.camera_translation, kMm);
  v.vector("camera_rotation_deg", w.camera_marker.camera_rotation, kDeg);
  v.number("mount_sd_mm", w.camera_marker.mount_sd, kMm, kNotNegative);
  v.number("mount_sd_deg", w.camera_marker.mount_sd_rad, kDeg, kNotNegative);

  v.section("pointer");
  v.rows("leds_mm", w.pointer.leds, kMm);
  v.vector("tip_mm", w.pointer.tip, kMm);
  v.number("touch_sd_mm", w.pointer.touch_sd, kMm, kNotNegative);
}

template <typename V, typename W>
void visit_arm_and_hand(V& v, W& w) {
  v.section("arm");
  v.choice("model", w.arm.model, {"phantom-premium-1.5", "laboratory-delta"});
  v.numbers("lengths_mm", w.arm.lengths, kMm, kPositive);
  v.number("length_sd_mm", w.arm.length_sd, kMm, kNotNegative);
  v.number("gain_sd", w.arm.gain_sd, kSi, {0.0, 0.2});
  v.number("offset_sd_deg", w.arm.offset_sd, kDeg, {0.0, 45.0});
  v.number("gimbal_gain_sd", w.arm.gimbal_gain_sd, kSi, {0.0, 0.2});
  v.number("gimbal_offset_sd_deg", w.arm.gimbal_offset_sd, kDeg, {0.0, 45.0});
  v.number("hysteresis_mrad", w.arm.hysteresis, 1e-3, kNotNegative);
  v.number("encoder_quantum_rad", w.arm.encoder_quantum, kSi, {0.0, 0.1});
  v.number("gimbal_quantum_rad", w.arm.gimbal_quantum, kSi, {0.0, 0.1});
  v.ranges("joint_range_deg", w.arm.joint_range, kDeg, {-180.0, 180.0});
  v.vector("workspace_mm", w.arm.workspace, kMm);
  v.pose("arm_in_world", w.arm.translation, w.arm.rotation);
  v.number("max_force_n", w.arm.max_force, kSi, kPositive);
  v.number("continuous_force_n", w.arm.continuous_force, kSi, kPositive);
  v.number("friction_n", w.arm.friction, kSi, kNotNegative);
  v.number("apparent_mass_kg", w.arm.apparent_mass, kSi, {1e-3, 100.0});
  v.number("max_stiffness_n_m", w.arm.max_stiffness, kSi, kPositive);
  v.number("max_speed_m_s", w.arm.max_speed, kSi, kPositive);
  v.integer("force_dof", w.arm.force_dof, {3.0, 3.0});

  if (v.takes(w.states_place())) {
    v.section("delta");
    v.number("length_sd_mm", w.delta.length_sd, kMm, kNotNegative);
    v.number("azimuth_sd_deg", w.delta.azimuth_sd, kDeg, {0.0, 10.0});
    v.number("zero_sd_deg", w.delta.zero_sd, kDeg, {0.0, 10.0});
  }

  if (v.takes(w.arm_faults.any())) {  // a world without them is written without their section
    v.section("arm_faults");
    v.integer("mirrored_axis", w.arm_faults.mirrored_axis, {0.0, 3.0});
    v.integers("exchanged_joints", w.arm_faults.exchanged_joints, {0.0, 3.0});
    v.numbers("torque_gains", w.arm_faults.torque_gains, kSi, {-10.0, 10.0});
  }

  if (v.takes(w.knock.any())) {
    v.section("knock");
    v.vector("camera_mm", w.knock.camera, kMm);
    v.vector("camera_deg", w.knock.camera_turn, kDeg);
    v.vector("base_mm", w.knock.base, kMm);
    v.vector("base_deg", w.knock.base_turn, kDeg);
    v.vector("table_mm", w.knock.table, kMm);
    v.vector("table_deg", w.knock.table_turn, kDeg);
    v.vector("tip_mm", w.knock.tip, kMm);
    v.vector("pointer_tip_mm", w.knock.pointer_tip, kMm);
    v.number("focus_percent", w.knock.focus, 0.01, {-50.0, 50.0});
    v.numbers("principal_point_px", w.knock.principal_point, kSi, {-100.0, 100.0});
  }

  v.section("hand");
  v.number("mass_kg", w.hand.mass, kSi, kNotNegative);
  v.number("damping_n_s_m", w.hand.damping, kSi, kNotNegative);
  v.number("stiffness_n_m", w.hand.stiffness, kSi, {0.0, 1e5});
  v.numbers("pull_n", w.hand.pull, kSi, kNotNegative);
  v.number("fixation_stiffness_n_m", w.hand.fixation_stiffness, kSi, kPositive);
}

template <typename V, typename W>
void visit_camera_and_head(V& v, W& w) {
  v.section("camera");
  v.integers("size_px", w.camera.size, {16.0, 16384.0});
  v.number("fx", w.camera.fx, kSi, kPositive);
  v.number("fy", w.camera.fy, kSi, kPositive);
  v.number("cx", w.camera.cx, kSi, kAnyNumber);
  v.number("cy", w.camera.cy, kSi, kAnyNumber);
  v.choice("lens", w.camera.lens, {device::kLensWords.begin(), device::kLensWords.end()});
  v.numbers("distortion", w.camera.distortion, kSi, kAnyNumber);
  v.numbers("denominator", w.camera.denominator, kSi, kAnyNumber);
  v.number("rate_hz", w.camera.rate_hz, kSi, {0.1, 10000.0});
  v.number("exposure_ms", w.camera.exposure_s, kMs, kNotNegative);
  v.number("latency_ms", w.camera.latency_s, kMs, kNotNegative);
  v.choice("shutter", w.camera.shutter, {"global", "rolling"});
  v.number("readout_ms", w.camera.readout_s, kMs, kNotNegative);
  v.integer("blur_steps", w.camera.blur_steps, {1.0, 32.0});
  v.number("noise_sd", w.camera.noise_sd, kSi, kNotNegative);
  v.number("drop_probability", w.camera.drop, kSi, kShare);
  v.integer("count", w.camera.count, {1.0, 2.0});
  v.number("stereo_baseline_mm", w.camera.stereo_baseline, kMm, kPositive);
  v.number("right_fx", w.camera.right_fx, kSi, kPositive);
  v.number("right_fy", w.camera.right_fy, kSi, kPositive);
  v.number("right_cx", w.camera.right_cx, kSi, kAnyNumber);
  v.number("right_cy", w.camera.right_cy, kSi, kAnyNumber);
  v.numbers("right_distortion", w.camera.right_distortion, kSi, kAnyNumber);
  v.numbers("right_denominator", w.camera.right_denominator, kSi, kAnyNumber);

  v.section("head");
  v.vector("eye_m", w.head.eye, kSi);
  v.vector("look_at_m", w.head.look_at, kSi);
  v.number("turn_peak_deg_s", w.head.turn_peak, kDeg, kNotNegative);
  v.number("turn_hz", w.head.turn_hz, kSi, {1e-3, 100.0});
  v.number("shake_deg", w.head.shake, kDeg, kNotNegative);
  v.number("shake_hz", w.head.shake_hz, kSi, {1e-3, 100.0});
}

template <typename V, typename W>
void visit_scene(V& v, W& w) {
  v.section("scene");
  v.rows("table_corners_m", w.scene.table, kSi);
  v.rows("wall_corners_m", w.scene.wall, kSi);
  v.integer("landmarks", w.scene.landmarks, {0.0, 200.0});
  v.number("landmarks_covered", w.scene.landmarks_covered, kSi, kShare);
  v.integer("landmarks_moved", w.scene.landmarks_moved, {0.0, 200.0});
  v.number("landmarks_moved_by_mm", w.scene.landmarks_moved_by, kMm, kNotNegative);

  v.section("display");
  v.choice("picture_time", w.display.picture_time, {"registered", "predicted"});
  v.number("scan_out_ms", w.display.scan_out_s, kMs, {0.0, 1000.0});
  v.number("extra_picture_delay_ms", w.display.extra_picture_delay_s, kMs, {0.0, 1000.0});
  v.number("extra_force_delay_ms", w.display.extra_force_delay_s, kMs, {0.0, 200.0});

  v.sections_of_applications();

  v.section("faults");
  v.numbers("camera_silent_s", w.faults.camera_silent, kSi, kFaultTimes);
  v.numbers("image_size_s", w.faults.image_size, kSi, kFaultTimes);
  v.numbers("camera_clock_s", w.faults.camera_clock, kSi, kFaultTimes);
  v.numbers("tracker_silent_s", w.faults.tracker_silent, kSi, kFaultTimes);
  v.numbers("tracker_blind_s", w.faults.tracker_blind, kSi, kFaultTimes);
  v.numbers("tracker_clock_s", w.faults.tracker_clock, kSi, kFaultTimes);
  v.number("clock_jump_s", w.faults.clock_jump_s, kSi, {-1e4, 1e4});
  v.number("repeat_s", w.faults.repeat_s, kSi, kFaultTimes);

  v.section("player");
  v.number("reaction_ms", w.player.reaction_s, kMs, kNotNegative);
  v.number("aim_sd_mm", w.player.aim_sd, kMm, kNotNegative);
  v.number("max_hand_acceleration_m_s2", w.player.max_hand_acceleration, kSi, kPositive);
  v.end_section();
}

template <typename V, typename W>
void visit(V& v, W& w) {
  visit_tracker(v, w);
  visit_arm_and_hand(v, w);
  visit_camera_and_head(v, w);
  visit_scene(v, w);
}

}  // namespace palpate::sim::config
