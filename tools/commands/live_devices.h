// A person at real devices: the options that name them, and the devices opened with the person led on this terminal, and
// in a window where that is asked for.
//
// One thread: that of the session. Errors: wrong use: not all three devices, or none of such a name; refused: a device that cannot be had, or
// goes meanwhile.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "palpate/calibration/session/acquisition_context.h"
#include "palpate/calibration/session/instruction_file.h"
#include "palpate/calibration/session/session_panel.h"
#include "palpate/desktop/session_view.h"
#include "palpate/rig/rig.h"
#include "tools/commands/camera_options.h"
#include "tools/commands/record_options.h"

namespace palpate::tools::commands {

struct LiveDevices {
  std::string arm, tracker, camera;
  std::vector<std::string> tools;  // MARKER=NAME
  CameraOptions camera_options;
  RecordOptions record;  // of the commands that record their session
  bool at_reset = false;
  bool window = false;
  std::string instructions;  // file of what is shown

  bool named() const { return !arm.empty() || !tracker.empty() || !camera.empty(); }
};

void add_device_options(CLI::App& command, LiveDevices& devices);

// For a window is for a person.
tl::unexpected<Error> window_without_devices();

// Runs a session: here, without an exchange, or, where a window is asked for, in a thread of its own while this one, the
// main thread, draws. Refused where no window can be had.
Expected<void> run_session(const LiveDevices& devices, const std::string& title,
                           const std::function<Expected<void>(desktop::SessionExchange*)>& session);

class LiveSession {
 public:
  // `known`: the drivers that open them. `exchange`: to the window; null where there is none.
  static Expected<std::unique_ptr<LiveSession>> open(const LiveDevices& devices, const rig::Rig& rig,
                                                     const device::DriverRegistry& known,
                                                     desktop::SessionExchange* exchange);
  ~LiveSession();
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  // As long as this object lives.
  calibration::session::AcquisitionContext context();
  calibration::session::SessionPanel& panel();
  device::ArmFacts arm_facts() const;
  // Where what is shown is written; outlives this object in whose hands it is.
  std::shared_ptr<calibration::session::InstructionFile> instructions() const;
  // The terminal is as it was; nothing else may be asked of this object.
  void end();

 private:
  struct Parts;
  explicit LiveSession(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate::tools::commands
