// How a command of the program is written: declare options, give an action; the action's error becomes one
// line on standard error and the exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/log.h"
#include "palpate/core/text.h"

namespace palpate::tools::commands {

using Action = std::function<Expected<void>()>;

// The action of whichever command was chosen; set by its callback while parsing, run by main afterwards.
void set_action(Action action);

// Runs `action` when `command` is chosen.
inline void on(CLI::App* command, Action action) {
  command->callback([action = std::move(action)] { set_action(action); });
}

// A line of an answer. What it quotes of files and of peers steers no terminal.
inline void print_line(const std::string& line, std::FILE* stream = stdout) {
  std::fprintf(stream, "%s\n", one_line(line).c_str());
  std::fflush(stream);  // whoever reads it through a pipe or a file reads it now
}

// Where an answer's lines for a person go: not to standard output where that is to have the JSON.
inline std::FILE* lines_beside(const std::string& json) { return json == "-" ? stderr : stdout; }

// What a person should know beside the answer: a line of the log, and with it on standard error.
inline void notice(const std::string& line) { Log().write(LogLevel::info, line); }

// All commands that this build has.
void add_commands(CLI::App& program);

// One function per command, each in a file of its own.
void add_calibrate_pivot(CLI::App& calibrate);
void add_calibrate_points(CLI::App& calibrate);
void add_calibrate_arm(CLI::App& calibrate);
void add_calibrate_surface(CLI::App& calibrate);
void add_calibrate_forces(CLI::App& calibrate);
void add_calibrate_landmarks(CLI::App& calibrate);
void add_calibrate_camera(CLI::App& calibrate);
void add_calibrate_hand_eye(CLI::App& calibrate);
void add_calibrate_headset(CLI::App& calibrate);
void add_calibrate_delay(CLI::App& calibrate);
void add_calibrate_all(CLI::App& calibrate);
void add_world(CLI::App& program);
void add_rig(CLI::App& program);
void add_rig_webcam(CLI::App& rig);
void add_report(CLI::App& program);
void add_study(CLI::App& program);
void add_study_flights(CLI::App& study);
void add_study_psychometric(CLI::App& study);
void add_study_indent(CLI::App& study);
void add_studies_of_applications(CLI::App& study);
void add_physics(CLI::App& program);
void add_graphics(CLI::App& program);
void add_demo(CLI::App& program);
void add_apps(CLI::App& program);
void add_keys(CLI::App& program);
void add_status(CLI::App& program);
void add_console(CLI::App& program);
void add_verify(CLI::App& program);
void add_doctor(CLI::App& program);
void add_manual(CLI::App& program);
void add_tracker(CLI::App& program);
void add_camera(CLI::App& program);
void add_picture(CLI::App& program);
void add_board(CLI::App& program);
void add_lockstep(CLI::App& program);
void add_play(CLI::App& program);
void add_convert(CLI::App& program);
void add_export(CLI::App& program);
void add_record(CLI::App& program);
void add_recording(CLI::App& program);
void add_replay(CLI::App& program);
void add_sample(CLI::App& program);

}  // namespace palpate::tools::commands
