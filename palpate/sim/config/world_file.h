// The world file: everything a simulated laboratory is made of, as numbers a person may change.
//
// The form is that of data/worlds/reference.toml; what a file leaves out has the reference's value. In the
// file millimetres, degrees and milliseconds (named in the keys), here SI and radians. Quantities called sd
// are drawn per seed, see truth.h. What applications let people set stands in the same file and is read as their
// schemas have it (palpate/scene/setting_schema.h); nothing of it is known here. Values, copied freely. Errors:
// wrong use with file and line.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/math/so3.h"
#include "palpate/scene/application_registry.h"

namespace palpate::sim::config {

struct ClockSettings {  // device time = host time (1 + drift) + offset
  double offset_s = 0.0;
  double drift = 0.0;
};

using Range = std::array<double, 2>;
using Corners = std::array<Vector3, 4>;  // in touching order

struct WorldFile {
  Vector3 gravity = Vector3::Zero();
  double rate_hz = 0.0;

  struct {
    ClockSettings arm, tracker, camera, graphics_host;
  } clocks;

  struct {
    std::array<Vector3, 3> cameras{};
    Vector3 look_at = Vector3::Zero();
    double optimal_distance = 0.0, rate_hz = 0.0, latency_s = 0.0;
    double white_rms = 0.0, bias_rms = 0.0, bias_correlation = 0.0;
    double dropout = 0.0;
    double max_led_angle = 0.0;
  } tracker;

  struct {
    std::vector<Vector3> leds;
    Vector3 tip = Vector3::Zero();
    double mount_sd = 0.0;
  } tip_marker;

  struct {
    std::vector<Vector3> leds;
    Vector3 camera_translation = Vector3::Zero(), camera_rotation = Vector3::Zero();  // angles about x, y, z
    double mount_sd = 0.0, mount_sd_rad = 0.0;
  } camera_marker;

  struct {
    std::vector<Vector3> leds;
    Vector3 tip = Vector3::Zero();
    double touch_sd = 0.0;
  } pointer;

  struct {
    std::string model;
    std::array<double, 2> lengths{};
    double length_sd = 0.0, gain_sd = 0.0, offset_sd = 0.0, gimbal_gain_sd = 0.0, gimbal_offset_sd = 0.0;
    double hysteresis = 0.0, encoder_quantum = 0.0, gimbal_quantum = 0.0;
    std::array<Range, 3> joint_range{};
    Vector3 workspace = Vector3::Zero();
    Vector3 translation = Vector3::Zero(),
            rotation = Vector3::Zero();  // ArmBase in World, angles about x, y, z
    double max_force = 0.0, continuous_force = 0.0, friction = 0.0, apparent_mass = 0.0, max_stiffness = 0.0;
    double max_speed = 0.0;
    int force_dof = 3;
  } arm;

  // Of an arm that states its place (arm.model = "laboratory-delta"): how far it is from its maker's drawing, one sigma. The
  // reference does not name it.
  struct Delta {
    double length_sd = 3e-4, azimuth_sd = 0.005, zero_sd = 0.008;  // m, rad, rad
  } delta;
  bool states_place() const { return arm.model == kDelta; }
  static constexpr const char* kDelta = "laboratory-delta";

  // An arm whose motors are wired wrongly on purpose, which the reference does not name: for the check of forces.
  struct ArmFaults {
    int mirrored_axis = 0;                              // of ArmBase: 1 x, 2 y, 3 z; 0: none
    std::array<int, 2> exchanged_joints{};              // 1 to 3; 0 0: none
    std::array<double, 3> torque_gains{1.0, 1.0, 1.0};  // of the joints' motors; 0: without power
    bool any() const {
      return mirrored_axis != 0 || exchanged_joints[0] != 0 || torque_gains != std::array{1.0, 1.0, 1.0};
    }
  } arm_faults;

  // What has been moved since the rig was calibrated, which the reference does not name: for palpate verify.
  // Drawn truths are changed by it (truth.h). Rotation vectors in rad.
  struct Knock {
    Vector3 camera = Vector3::Zero(), camera_turn = Vector3::Zero();  // in its marker, CameraMarker axes
    Vector3 base = Vector3::Zero(), base_turn = Vector3::Zero();    // the arm's, about its origin, World axes
    Vector3 table = Vector3::Zero(), table_turn = Vector3::Zero();  // with wall, landmarks and board; World
    Vector3 tip = Vector3::Zero(), pointer_tip = Vector3::Zero();   // in their markers, which were bent
    double focus = 0.0;                                             // by so much of the focal length
    std::array<double, 2> principal_point{};                        // px
    bool any() const {
      double sum = std::abs(focus) + std::abs(principal_point[0]) + std::abs(principal_point[1]);
      for (const auto* move :
           {&camera, &camera_turn, &base, &base_turn, &table, &table_turn, &tip, &pointer_tip})
        sum += move->norm();
      return sum > 0.0;
    }
  } knock;

  struct {
    double mass = 0.0, damping = 0.0, stiffness = 0.0;
    Range pull{};  // N
    double fixation_stiffness = 0.0;
  } hand;

  struct {
    std::array<int, 2> size{};
    double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;
    std::array<double, 5> distortion{};   // k1 k2 p1 p2 k3, or k1 k2 k3 k4 0
    std::array<double, 3> denominator{};  // k4 k5 k6 of a rational lens
    std::string lens = "brown";           // of both cameras (device::LensKind)
    double rate_hz = 0.0, exposure_s = 0.0, latency_s = 0.0;
    std::string shutter;
    double readout_s = 0.0;  // first to last row; rolling shutter only
    int blur_steps = 1;      // moments of the exposure a picture is averaged from; 1: sharp, and cheap
    double noise_sd = 0.0, drop = 0.0;
    // A second camera to the right of the first on the same head, which takes its images at the same moments:
    // size, rate, shutter and noise are the first one's, the lens its own.
    int count = 1;
    double stereo_baseline = 0.0;
    double right_fx = 558.0, right_fy = 559.0, right_cx = 322.0, right_cy = 239.0;
    std::array<double, 5> right_distortion{-0.26, 0.08, -0.0007, 0.0009, 0.0};
    std::array<double, 3> right_denominator{};
  } camera;

  struct {
    Vector3 eye = Vector3::Zero(), look_at = Vector3::Zero();
    double turn_peak = 0.0, turn_hz = 0.0, shake = 0.0, shake_hz = 0.0;  // rad/s, Hz, rad, Hz
  } head;

  struct {
    Corners table{}, wall{};
    int landmarks = 0;
    // Once play begins: share of the landmarks that is covered, other ones every second; how many have been
    // moved since they were calibrated, and by how much.
    double landmarks_covered = 0.0;
    int landmarks_moved = 0;
    double landmarks_moved_by = 0.0;
  } scene;

  // What pictures show, and delays on purpose, for experiments.
  struct {
    std::string picture_time = "registered";  // or "predicted"
    double scan_out_s = 0.0, extra_picture_delay_s = 0.0, extra_force_delay_s = 0.0;
  } display;

  // Devices that fail on purpose (palpate/sim/device_faults.h), which the reference does not name: spans in
  // s since play began, an empty one is never; again every repeat_s where that is not 0.
  struct {
    Range camera_silent{}, image_size{}, camera_clock{}, tracker_silent{}, tracker_blind{}, tracker_clock{};
    double clock_jump_s = 3.0, repeat_s = 0.0;
  } faults;

  struct {
    double reaction_s = 0.0, aim_sd = 0.0, max_hand_acceleration = 0.0;
  } player;

  // Of the applications: their sections, and keys of theirs in the laboratory's.
  scene::SettingValues settings;
};

// First to last row of the camera's shutter: 0 where it is a global one.
inline double readout_s(const WorldFile& world) {
  return world.camera.shutter == "rolling" ? world.camera.readout_s : 0.0;
}

// The reference world, compiled in: as a file with its comments, and as values. Without applications their
// part of it is left out.
std::string_view reference_world_text();
const WorldFile& reference_world();
WorldFile reference_world(const scene::ApplicationRegistry& applications);

// Keys that neither the laboratory nor one of `applications` has are refused, but for those that the reference
// world names: they are of an application that is not here.
Expected<WorldFile> parse_world(std::string_view content, const std::string& source,
                                const scene::ApplicationRegistry& applications);
Expected<WorldFile> read_world(const std::filesystem::path& path,
                               const scene::ApplicationRegistry& applications);

// The world as a file (no comments); read back it gives the same world.
std::string world_text(const WorldFile& world);

}  // namespace palpate::sim::config
