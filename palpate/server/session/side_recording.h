// Records beside a running system: the states of its world as an observer gets them, and what a tracker and a camera measure that
// others may read as well. It disturbs nobody: a subscriber that is slow loses states, which are counted.
//
// One thread; returns when its time is over or somebody asks for the end. Errors: refused where the physics server does not
// answer, a device cannot be had or has gone, or the disk refuses.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/device/driver_registry.h"
#include "palpate/record/session/recorded_drivers.h"
#include "palpate/transport/server_place.h"

namespace palpate::server::session {

struct SideRecordingOptions {
  transport::ServerName server;
  int rate_hz = 250;  // of the states, 1 to 1000
  device::DriverRegistry drivers;
  std::optional<device::TrackerRequest> tracker;
  std::optional<device::CameraRequest> camera;
  record::session::PictureRecording pictures;
  std::filesystem::path out;
  double seconds = 0.0;         // 0 = until asked to stop
  std::function<void()> ready;  // called once, when it records
};

// What the file holds: seconds, messages, bytes, dropped by topic; states that were skipped or missed on the way.
Expected<Json> record_beside(const SideRecordingOptions& options);

}  // namespace palpate::server::session
