// A device as a driver hands it over: what it measures and is commanded (devices.h), and what the driver knows of it
// beside that: who it is, how it is doing, what happened to it.
//
// One ordinary thread, while the device itself may be used by another. Errors: in words for a person.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/device/devices.h"
#include "palpate/device/health.h"

namespace palpate::device {

template <typename Device>
class Opened {
 public:
  virtual ~Opened() = default;
  virtual Device& device() = 0;
  // To be called at least some ten times a second. Refused: it is gone for good, and who uses it has to end.
  virtual Expected<void> look() { return {}; }
  // What is wrong with it now, such as that it is unplugged, and its end in words of its own where it has some; nothing:
  // all is well. Asked as often; whether that is news, others judge (health_monitor.h).
  virtual std::optional<HealthReport> health() { return std::nullopt; }
  // What happened to it, for figures; null where there is nothing to tell.
  virtual Json figures() const { return nullptr; }
};

struct ArmFacts {
  // A computed arm: nobody is hurt by it.
  bool simulated = false;
  // Who it is, the same whenever it is opened: driver, model, serial number.
  std::string identity{};
  // How many its samples have.
  int joints = 3;
  // They are the place of its tip, m, in place of joints (ArmModel::Kind::cartesian).
  bool states_place = false;
  // N at the tip, as the device states them; none: it states nothing.
  std::optional<double> peak_n{}, continuous_n{};
};

class OpenedArm : public Opened<ArmDevice> {
 public:
  virtual ArmFacts facts() const = 0;
  // One line of who it is, for the log; empty: nothing to say.
  virtual std::string description() const { return ""; }
};

class OpenedTracker : public Opened<TrackerDevice> {
 public:
  // Why nothing may be heard of the camera's marker, in words; empty: it has nothing to say of that. Whether
  // it is not heard of, others judge.
  virtual std::string why_unheard() const { return ""; }
};

class OpenedCamera : public Opened<CameraDevice> {
 public:
  // Computed, as is the display before it.
  virtual bool simulated() const { return false; }
  virtual std::string name() const = 0;              // "v4l2:/dev/video0", as a person would name it
  virtual std::string description() const = 0;       // one line: model, size, format
  virtual double exposure_s() const { return 0.0; }  // 0: not told
  // A recording that has no more.
  virtual bool ended() const { return false; }
  // Of two cameras that are one device and stamp by one clock: the right one, opened by the first call. Null:
  // there is none.
  virtual Expected<CameraDevice*> right() { return nullptr; }
};

using OpenedHand = Opened<HandDevice>;
using OpenedDisplay = Opened<DisplayDevice>;

}  // namespace palpate::device
