#include "palpate/device/health.h"

namespace palpate::device {
namespace {

struct Facts {
  HealthCode code;
  const char* name;
  Severity severity;
  HealthCode subject;
  bool words_stay;
  const char* end;
};

using enum HealthCode;
using enum Severity;

constexpr std::array<Facts, kHealthCodes> kFacts{{
    {camera_silent, "camera_silent", fault, camera_silent, false, "camera: images come again"},
    {camera_unfit, "camera_unfit", fault, camera_silent, false, "camera: images come again"},
    {camera_lost, "camera_lost", fault, camera_silent, true, "camera: images come again"},
    {recording_ended, "recording_ended", notice, camera_silent, false, "camera: images come again"},
    {image_size, "image_size", fault, image_size, false, "camera: images have the calibrated size again"},
    {camera_clock, "camera_clock", notice, camera_clock, false, "camera: its clock is known again"},
    {tracker_silent, "tracker_silent", fault, tracker_silent, false, "tracker: samples come again"},
    {tracker_clock, "tracker_clock", notice, tracker_clock, false, "tracker: its clock is known again"},
    {tracker_blind, "tracker_blind", fault, tracker_blind, false, "tracker: sees the head's marker again"},
    {landmarks_lost, "landmarks_lost", warning, landmarks_lost, true,
     "landmarks: they steady the picture again"},
    {right_eye_lost, "right_eye_lost", warning, right_eye_lost, false,
     "right camera: each eye has its own picture again"},
    {board_lost, "board_lost", fault, board_lost, true, "board: found again"},
    {arm_lost, "arm_lost", fault, arm_lost, true, "arm: works again"},
    {arm_inconsistent, "arm_inconsistent", fault, arm_lost, true, "arm: works again"},
    {arm_uncalibrated, "arm_uncalibrated", fault, arm_lost, true, "arm: works again"},
    {arm_forces_off, "arm_forces_off", warning, arm_lost, true, "arm: works again"},
    {laboratory_silent, "laboratory_silent", fault, laboratory_silent, false, "laboratory: goes on"},
    {physics_server_gone, "physics_server_gone", fault, physics_server_gone, false,
     "the physics server answers again"},
    {other_scene, "other_scene", fault, other_scene, false, "the physics server plays again what is drawn"},
    {other_rig, "other_rig", warning, other_rig, false, "the physics server has the same rig again"},
}};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kFacts.size(); ++i)
    if (kFacts[i].code != static_cast<HealthCode>(i)) return false;
  return true;
}
static_assert(in_order());

const Facts& facts_of(HealthCode code) { return kFacts[static_cast<std::size_t>(code)]; }

}  // namespace

std::string_view name_of(HealthCode code) { return facts_of(code).name; }
Severity severity_of(HealthCode code) { return facts_of(code).severity; }
std::string_view end_of(HealthCode code) { return facts_of(code).end; }
HealthCode subject_of(HealthCode code) { return facts_of(code).subject; }
bool words_stay(HealthCode code) { return facts_of(code).words_stay; }

std::string_view name_of(Severity severity) {
  constexpr std::array kNames{"notice", "warning", "fault"};
  return kNames[static_cast<std::size_t>(severity)];
}

}  // namespace palpate::device
