#include "tools/commands/command.h"

namespace palpate::tools::commands {

void add_commands(CLI::App& program) {
  auto* calibrate =
      program.add_subcommand("calibrate", "Calibrate arm, tracker, camera and surfaces to each other");
  calibrate->require_subcommand(1);
  add_calibrate_pivot(*calibrate);
  add_calibrate_points(*calibrate);
  add_calibrate_arm(*calibrate);
  add_calibrate_surface(*calibrate);
  add_calibrate_forces(*calibrate);
  add_calibrate_landmarks(*calibrate);
  add_calibrate_camera(*calibrate);
  add_calibrate_hand_eye(*calibrate);
  add_calibrate_headset(*calibrate);
  add_calibrate_delay(*calibrate);
  add_calibrate_all(*calibrate);
  add_demo(program);
  add_lockstep(program);
  add_apps(program);
  add_world(program);
  add_rig(program);
  add_report(program);
  add_study(program);
  add_physics(program);
  add_graphics(program);
  add_keys(program);
  add_status(program);
  add_console(program);
  add_picture(program);
  add_tracker(program);
  add_camera(program);
  add_board(program);
  add_play(program);
  add_record(program);
  add_recording(program);
  add_convert(program);
  add_export(program);
  add_replay(program);
  add_sample(program);
  add_verify(program);
  add_doctor(program);
  add_manual(program);
}

}  // namespace palpate::tools::commands
