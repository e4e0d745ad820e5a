#include <algorithm>
#include <memory>

#include "palpate/calibration/findings/hand_eye.h"
#include "palpate/core/units.h"
#include "tools/commands/command.h"
#include "tools/commands/hand_eye_output.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {
namespace {

struct HeadsetArguments {
  ResultOptions result;
  std::string head, camera;
};

// The hand-eye calibration's equation, hand(t + delay) X = Z eye(t): the head is the hand, and the camera, whose pose in
// World our own registration gives, the eye. Z is World in the headset's room.
Json headset_json(const HeadsetArguments& options, const Estimate<calibration::HandEyeSolution>& fit,
                  const std::string& hash) {
  const auto& s = fit.value;
  Json json = calibration::findings::hand_eye_place_json(s);
  json["world_in_headset_room"] = {{"translation_mm", json_list(s.X_world_board.translation, kMm)},
                                   {"rotation_qwxyz", json_quaternion(s.X_world_board.rotation)}};
  json["camera_poses"] = s.pairs;
  json["rotation_range_deg"] = degrees_from_radians(s.rotation_range);
  json["warnings"] = s.warnings;
  json["std"] = calibration::findings::hand_eye_std_json(fit);
  json["data"] = {{"head", options.head}, {"camera", options.camera}, {"hash", hash}};
  return json;
}

std::vector<std::string> headset_summary(const Estimate<calibration::HandEyeSolution>& fit) {
  const auto& s = fit.value;
  const auto sd = standard_deviations(fit.covariance);
  std::vector<std::string> lines{
      fmt::format("camera before the eyes  {} mm  +- {}", shown(s.X_marker_camera.translation, kMm),
                  shown(sd.segment<3>(3), kMm)),
      fmt::format("turned by               {} deg about x, y, z  +- {}",
                  shown(so3_log(s.X_marker_camera.rotation), kDegreesPerRadian),
                  shown(sd.segment<3>(0), kDegreesPerRadian)),
      fmt::format("delay                   {:.5f} +- {:.5f} s (headset's time = image's time + delay)",
                  s.delay_s, s.delay_std_s),
      fmt::format("residual                median {:.3f} deg, {:.3f} mm over {} camera poses",
                  degrees_from_radians(s.rotation_residual_median), kMm * s.translation_residual_median,
                  s.pairs)};
  for (const auto& warning : s.warnings) lines.push_back("warning: " + warning);
  return lines;
}

Expected<void> calibrate_headset(const HeadsetArguments& options) {
  if (const auto rig = start_rig(options.result); !rig) return tl::unexpected(rig.error());
  const auto pair =
      read_pose_pair(options.head, options.camera,
                     "the head's poses by the headset (--head) and the camera's in World (--camera)");
  if (!pair) return tl::unexpected(pair.error());
  for (const auto& [file, poses] :
       {std::pair{&options.head, &pair->hand}, std::pair{&options.camera, &pair->eye}})
    if (!poses->has_time)
      return wrong_use(
          "{}: has no times; poses with time_s are expected, as `palpate graphics --headset --out` "
          "writes them",
          *file);
  const auto fit =
      calibration::calibrate_hand_eye(pair->hand.poses, pair->eye.poses, {.estimate_delay = true});
  if (!fit)
    return tl::unexpected(Error{
        fit.error().kind, fmt::format("{}, {}: {}", options.head, options.camera, fit.error().message)});
  Result result{headset_json(options, *fit, pair->hash), headset_summary(*fit), {}};
  result.store = [&](rig::Rig& rig) {
    const auto& s = fit->value;
    rig.headset = rig::HeadsetCalibration{{s.X_marker_camera.rotation, s.X_marker_camera.translation},
                                          fit->covariance.topLeftCorner<6, 6>(),
                                          s.delay_s,
                                          s.delay_std_s,
                                          {rig::utc_now(), pair->hash, "joint", kMm * s.translation_rms}};
  };
  return write_result(options.result, result);
}

}  // namespace

void add_calibrate_headset(CLI::App& calibrate) {
  auto options = std::make_shared<HeadsetArguments>();
  auto* command = calibrate.add_subcommand(
      "headset", "The camera before the eyes of who wears the headset, and how late the headset's poses are");
  command->add_option("--head", options->head, "Poses of the head by the headset: headset_head.csv")
      ->type_name("FILE")
      ->required();
  command->add_option("--camera", options->camera, "Poses of the camera in World: headset_camera.csv")
      ->type_name("FILE")
      ->required();
  add_result_options(*command, options->result);
  on(command, [options] { return calibrate_headset(*options); });
}

}  // namespace palpate::tools::commands
