// What goes wrong with camera and tracker on purpose: `[faults]` of a world file, for tests and for whoever
// wants to see what is said and done then.
//
// A fault holds within its span of seconds since play began, again every repeat_s where that is given. It
// changes what a device hands out, on its way: images stay away or have half the width and height, samples
// stay away or do not show the head's marker, stamps are those of a clock that is clock_jump_s ahead. The
// world itself, and the arm, know nothing of it. Values, any thread.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "palpate/device/devices.h"
#include "palpate/device/health.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::sim {

class DeviceFaults {
 public:
  explicit DeviceFaults(const config::WorldFile& world) : faults_(world.faults) {}

  // At `t` seconds since play began.
  void disturb(double t, std::optional<device::CameraImage>& image) const;
  void disturb(double t, std::vector<device::TrackerSample>& samples) const;
  // Each, and whether it holds; the world file has them by the codes' names.
  std::vector<std::pair<device::HealthCode, bool>> at(double t) const;

 private:
  bool holds(const config::Range& span, double t) const;
  decltype(config::WorldFile::faults) faults_;
};

}  // namespace palpate::sim
