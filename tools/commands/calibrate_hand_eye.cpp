#include <memory>
#include <tuple>

#include "palpate/calibration/findings/hand_eye.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/hand_eye_arguments.h"
#include "tools/commands/hand_eye_output.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

namespace findings = calibration::findings;

Expected<void> run_hand_eye_poses(const HandEyeArguments& options) {
  const auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  const auto pair =
      read_pose_pair(options.hand, options.eye,
                     "the marker's poses in the tracker (--hand) and the camera's at the board (--eye)");
  if (!pair) return tl::unexpected(pair.error());
  const device::PoseFile &hand = pair->hand, &eye = pair->eye;
  calibration::HandEyeOptions how{.estimate_delay = options.estimate_delay, .delay_s = options.delay_s};
  // Rows that are not each other's would be paired.
  for (const auto* file : {&hand, &eye})
    if (!file->unread_time.empty())
      return wrong_use("{}: is '{}' its time? time_s (in s) is what is read; rename it or leave it out",
                       file->source, excerpt(file->unread_time));
  if (hand.has_time != eye.has_time)
    return wrong_use("{}: has no times, {} has; both or neither is expected",
                     hand.has_time ? options.eye : options.hand, hand.has_time ? options.hand : options.eye);
  if (!hand.has_time) {  // row k of one belongs to row k of the other
    if (options.estimate_delay)
      return wrong_use("{}: has no times; --estimate-delay needs them", options.hand);
    if (hand.poses.size() != eye.poses.size())
      return wrong_use("{}: has {}, {} has {}; without times they belong together one by one", options.hand,
                       counted(hand.poses.size(), "pose"), options.eye, eye.poses.size());
    how.max_hand_gap_s = findings::kRowByRow;
    how.doubt_delay = false;
  }
  const auto fit = calibration::calibrate_hand_eye(hand.poses, eye.poses, how);
  if (!fit)
    return tl::unexpected(
        Error{fit.error().kind, fmt::format("{}, {}: {}", options.hand, options.eye, fit.error().message)});

  const auto& s = fit->value;
  const auto sd = standard_deviations(fit->covariance);
  Result result{findings::hand_eye_json(*fit), {}, {}};
  result.json["data"] = {{"hand", options.hand}, {"eye", options.eye}, {"hash", pair->hash}};
  result.summary.push_back(fmt::format("camera in marker  {} mm  +- {}",
                                       shown(s.X_marker_camera.translation, kMm),
                                       shown(sd.segment<3>(3), kMm)));
  const Vector3 turn = so3_log(s.X_marker_camera.rotation);
  result.summary.push_back(fmt::format("turned by         {} deg about x, y, z  +- {}",
                                       shown(turn, kDegreesPerRadian),
                                       shown(sd.segment<3>(0), kDegreesPerRadian)));
  if (options.estimate_delay)
    result.summary.push_back(fmt::format(
        "delay             {:.5f} +- {:.5f} s (hand time = eye time + delay)", s.delay_s, s.delay_std_s));
  result.summary.push_back(fmt::format("residual          median {:.3f} deg, {:.3f} mm over {} eye poses",
                                       degrees_from_radians(s.rotation_residual_median),
                                       kMm * s.translation_residual_median, s.pairs));
  if (const auto& before = options.camera == "right" ? rig->right_hand_eye : rig->hand_eye; before)
    if (auto worse =
            warning_of_worse("this camera's place", before->X_marker_camera.translation,
                             before->covariance.bottomRightCorner<3, 3>(), fit->covariance.block<3, 3>(3, 3));
        !worse.empty())
      result.json["warnings"].push_back(worse);
  if (auto apart = warning_of_clocks(options.estimate_delay ? s.delay_s : 0.0); !apart.empty())
    result.json["warnings"].push_back(apart);
  for (const auto& warning : result.json["warnings"])
    result.summary.push_back("warning: " + warning.get<std::string>());
  result.store = [&](rig::Rig& target) {
    const rig::Provenance from{rig::utc_now(), pair->hash, "joint", kMm * s.translation_rms};
    auto& hand_eye = options.camera == "right" ? target.right_hand_eye : target.hand_eye;
    hand_eye = rig::HandEyeCalibration{s.X_marker_camera, fit->covariance.topLeftCorner<6, 6>(), from};
    if (!options.estimate_delay || options.camera == "right") return;  // both take their images together
    set_camera_delay(target, s.delay_s, s.delay_std_s, from);
  };
  return write_result(options.result, result);
}

Expected<void> run_hand_eye(const HandEyeArguments& options, const CLI::App& command) {
  const bool corners = !options.board.images.empty() || !options.board.corners.empty();
  if (corners == !options.eye.empty())
    return wrong_use(
        "calibrate hand-eye: either --eye (the camera's poses) or one of --corners and --images (the board's "
        "views) is expected");
  if (corners) return run_hand_eye_pixels(options);
  if (auto fine = refuse_given(command,
                               {"--board", "--square-mm", "--size-px", "--corner-window-px", "--stamps",
                                "--lens", "--lens-model", "--tracker-sd-mm", "--tracker-sd-deg"},
                               "goes with --images or --corners, not with --eye");
      !fine)
    return fine;
  return run_hand_eye_poses(options);
}

}  // namespace

void add_calibrate_hand_eye(CLI::App& calibrate) {
  auto options = std::make_shared<HandEyeArguments>();
  auto* command =
      calibrate.add_subcommand("hand-eye", "The camera in its marker's frame, and the clocks' offset");
  command->add_option("--hand", options->hand, "Poses of the marker in the tracker")->type_name("FILE");
  command->add_option("--eye", options->eye, "Poses of the camera in the board's frame")->type_name("FILE");
  add_board_options(*command, options->board);
  command->add_option("--stamps", options->stamps, "When each image was taken, a CSV table image,time_s")
      ->type_name("FILE");
  command
      ->add_option("--lens", options->lens,
                   "With --corners or --images: the lens, a rig file, a result of calibrate camera or a lens "
                   "of another program; found too "
                   "where neither this nor the rig has it")
      ->type_name("FILE");
  add_lens_model_option(*command, options->lens_model);
  for (const auto& [name, value, what] : {std::tuple{"--tracker-sd-mm", &options->tracker_sd_mm, "shift"},
                                          {"--tracker-sd-deg", &options->tracker_sd_deg, "turn"}})
    command
        ->add_option(
            name, *value,
            fmt::format("With --corners or --images: the tracker's error, a {} per axis; told by the "
                        "residuals where it is not given",
                        what))
        ->check(above_zero());
  auto* estimate = command->add_flag("--estimate-delay", options->estimate_delay,
                                     "Find the offset of the two streams' clocks");
  command->add_option("--delay-s", options->delay_s, "A known offset: hand time = eye time + this")
      ->excludes(estimate)
      ->capture_default_str();
  add_camera_option(*command, options->camera);
  add_result_options(*command, options->result);
  const auto tables = std::make_shared<TableSource>();
  tables->add("--hand", options->hand, "hand");
  tables->add(
      "--eye", options->eye,
      [options] {
        return options->board.images.empty() && options->board.corners.empty() ? std::string("eye")
                                                                               : std::string();
      },
      false);
  tables->add_options(*command);
  on(command, tables, [options, command] { return run_hand_eye(*options, *command); });
}

}  // namespace palpate::tools::commands
