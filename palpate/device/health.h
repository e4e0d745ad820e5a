// What is wrong with a device or a peer right now: one type for whoever judges, decides, logs, sends and shows it.
//
// A report says how things stand, and in what words; a monitor (health_monitor.h) makes conditions of reports, which have
// a beginning and an end, and tells the log. Values, any thread. What holds for the forces alone is in force_condition.h.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "palpate/time/instant.h"

namespace palpate::device {

enum class HealthCode : std::uint8_t {
  camera_silent,        // no images
  camera_unfit,         // images come, none of which can be used: another size or format, damaged
  camera_lost,          // unplugged, taken away, not to be opened
  recording_ended,      // the camera is a recording that has no more
  image_size,           // images of another size than the calibrated camera's: not drawn
  camera_clock,         // its clock was set or stood still: images cannot be placed in time for a moment
  tracker_silent,       // no samples at all
  tracker_clock,        // as the camera's
  tracker_blind,        // samples, but the head's marker is not among what it sees
  landmarks_lost,       // the picture rests on the tracker alone
  right_eye_lost,       // of two cameras the right one: both eyes see the left one's picture
  board_lost,           // the board by which the camera knows its place is not found in the picture
  arm_lost,             // no samples; it is opened again when it returns
  arm_inconsistent,     // angles and places of the tip do not fit: no forces until it is opened anew
  arm_uncalibrated,     // waits for a person; no samples
  arm_forces_off,       // the device has complained of a force; samples go on
  laboratory_silent,    // the simulated laboratory stands still
  physics_server_gone,  // it no longer answers
  other_scene,          // it plays something else than the pictures are made for: they show none of it
  other_rig  // it has surfaces or the arm elsewhere than we: forces and pictures are not in one place
};
inline constexpr std::size_t kHealthCodes = 20;

enum class Severity : std::uint8_t {
  notice,   // passes by itself, or was to be expected
  warning,  // it goes on, with less than it should
  fault     // what the device is for does not happen meanwhile
};

std::string_view name_of(HealthCode code);  // as raw data and figures have it: "camera_silent"
std::string_view name_of(Severity severity);
Severity severity_of(HealthCode code);
// What the end is called where a report does not say it: "camera: images come again".
std::string_view end_of(HealthCode code);
// Reports of one and the same thing have the same: one takes the other's place, and the condition goes on.
HealthCode subject_of(HealthCode code);
// Words that would change with every image, or with every attempt to open it again: those of the beginning stay.
bool words_stay(HealthCode code);

struct HealthReport {
  HealthCode code = HealthCode::camera_silent;
  std::string words;  // one line: the thing, the value, the expectation and the remedy
  std::string end{};  // what the end is called; empty: end_of(code)
  bool operator==(const HealthReport&) const = default;
};

template <typename Clock>
struct HealthCondition : HealthReport {
  Instant<Clock> since;
  Severity severity() const { return severity_of(code); }
};

}  // namespace palpate::device
