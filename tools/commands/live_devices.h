// A person at real devices: the options that name them, and the devices opened with the person led on this terminal.
//
// One thread. Errors: wrong use: not all three devices, or none of such a name; refused: a device that cannot be had, or
// goes meanwhile.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "palpate/calibration/session/acquisition_context.h"
#include "palpate/rig/rig.h"
#include "tools/commands/camera_options.h"
#include "tools/commands/record_options.h"
#include "tools/commands/terminal_panel.h"

namespace palpate::tools::commands {

struct LiveDevices {
  std::string arm, tracker, camera;
  std::vector<std::string> tools;  // MARKER=NAME
  CameraOptions camera_options;
  RecordOptions record;  // of the commands that record their session
  bool at_reset = false;
  std::string instructions;  // file of what is shown

  bool named() const { return !arm.empty() || !tracker.empty() || !camera.empty(); }
};

void add_device_options(CLI::App& command, LiveDevices& devices);

class LiveSession {
 public:
  // `known`: the drivers that open them.
  static Expected<std::unique_ptr<LiveSession>> open(const LiveDevices& devices, const rig::Rig& rig,
                                                     const device::DriverRegistry& known);
  ~LiveSession();
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  // As long as this object lives.
  calibration::session::AcquisitionContext context();
  TerminalPanel& panel();
  // The terminal is as it was; nothing else may be asked of this object.
  void end();

 private:
  struct Parts;
  explicit LiveSession(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpate::tools::commands
