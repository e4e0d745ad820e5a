// Where the samples of `palpate sample` come from, devices or a recording, and what every kind of it does with them: one code path
// once they are in memory.
//
// Devices are read each millisecond until --seconds are over, Ctrl-C, or a device is gone: what there is until then is kept. A
// recording is read at once. Times are the machine's monotonic clock, of a recording seconds after its first message. One thread.
// Errors: wrong use: neither or both of devices and recording; refused: a device that cannot be had, a recording without the
// stream.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "palpate/calibration/session/holds.h"
#include "palpate/core/json.h"
#include "palpate/device/device_streams.h"
#include "palpate/record/session/recorded_tables.h"
#include "palpate/rig/rig.h"
#include "tools/commands/camera_options.h"
#include "tools/commands/record_options.h"

namespace palpate::tools::commands {

struct SampleArguments {
  std::string arm, tracker, camera;
  std::vector<std::string> tracker_tools;  // MARKER=NAME
  CameraOptions camera_options;
  RecordOptions record;  // the raw streams of the devices, kept beside the tables
  bool at_reset = false;
  std::string recording, which_camera = "left";
  record::session::TimeSpan span;
  double seconds = 0.0;
  std::string rig, out, json;
};

// Which devices a kind of sample needs; `keys`: lines of standard input are moments that a person marks.
struct SampleNeeds {
  bool arm = false, tracker = false, camera = false, keys = false;
  std::function<void(const device::CameraImage&)> picture{};  // each, with its pixels
  std::function<std::string()> progress{};                    // more for the progress line
};

void add_sample_options(CLI::App& command, SampleArguments& options, const SampleNeeds& needs);
// --still-mm, --still-deg, --still-s: what counts as held still.
void add_still_options(CLI::App& command, calibration::session::HoldSettings& settings);

struct TakenSamples {
  device::DeviceStreams streams;
  std::vector<double> keys_s;  // host time
  double seconds = 0.0;
  std::string source;  // for messages: the recording, or the tracker
  std::vector<std::string> warnings;
};

Expected<TakenSamples> take_samples(const SampleArguments& options, const SampleNeeds& needs);

// The rig of --rig; without, an empty one whose arm is that of the recording's rig.
Expected<rig::Rig> rig_of_samples(const SampleArguments& options);

// A marker by its name, wrong use for others.
Expected<device::MarkerId> sampled_marker(const std::string& name);
// The seen and unseen poses of a marker, in the frame of `reference` where it is named. Refused where none is seen.
Expected<std::vector<device::TrackedPose>> sampled_poses(const TakenSamples& taken, device::MarkerId marker,
                                                         const std::string& reference);

// Writes the tables into the folder, then tells a person, or JSON, what there is: `counts` beside the files' rows.
struct SampleTable {
  std::string file, content;
  std::size_t rows = 0;
};
Expected<void> write_samples(const SampleArguments& options, const std::string& kind,
                             const TakenSamples& taken, const std::vector<SampleTable>& tables,
                             const Json& counts, const std::string& next_command);

}  // namespace palpate::tools::commands
