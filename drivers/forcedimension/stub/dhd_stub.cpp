// A stand-in for the maker's libdhd.so with simulated devices, in the same binary interface.
//
// Written from the published behaviour, with its own values and types: a mistake in the driver's declarations shows here.
#include "drivers/forcedimension/stub/dhd_stub.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace {

constexpr int kDevices = 3;
enum {
  kPower,
  kConnected,
  kStarted,
  kReset,
  kIdle,
  kForce,
  kBrake,
  kTorque,
  kWristDetected,
  kError,
  kGravity,
  kTimeGuard,
  kWristInit,
  kRedundancy,
  kForceOffCause,
  kLocks,
  kAxisChecked,
  kStatusCount
};
constexpr int kButtonCause = 1, kWatchdogCause = 3, kSoftwareCause = 4;

struct Everything {
  std::array<DhdStubDevice, kDevices> devices;
  bool expert = false;
  unsigned long looks = 0;
};

Everything& all() {
  static auto* everything = new Everything;  // outlives every thread
  return *everything;
}
thread_local const char* last_error = "no error";

void furnish() {
  for (int i = 0; i < kDevices; ++i) {
    DhdStubDevice& device = all().devices[static_cast<std::size_t>(i)];
    device.serial = static_cast<unsigned short>(1001 + i);
    device.plugged = i == 0;
  }
  all().devices[1].type = 104;
  all().devices[1].name = "sigma.7";
  all().devices[1].wrist = true;
  all().devices[2].type = 81;
  all().devices[2].name = "controller";
}

int fail(const char* words) {
  last_error = words;
  return -1;
}

double now_s(const DhdStubDevice& device) {
  return device.clock_s >= 0.0
             ? device.clock_s
             : std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void switch_off(DhdStubDevice& device, int cause) {
  if (device.forces_on) device.off_cause = cause;
  device.forces_on = false;
  std::fill_n(device.force, 3, 0.0);
}

// What the firmware does of its own.
void pass_time(DhdStubDevice& device) {
  if (!device.powered) switch_off(device, 0);
  if (device.forces_on && device.watchdog_s > 0.0 &&
      now_s(device) - device.commanded_at_s > device.watchdog_s)
    switch_off(device, kWatchdogCause);
}

void hold(DhdStubDevice& device) {
  if (!device.hand) return;
  constexpr double kCycle = 1e-3;  // s
  double push[3] = {device.force[0], device.force[1], device.force[2]};
  if (device.mirrored_axis > 0) push[device.mirrored_axis - 1] *= -1.0;
  if (device.exchanged[0] > 0) std::swap(push[device.exchanged[0] - 1], push[device.exchanged[1] - 1]);
  for (int i = 0; i < 3; ++i)
    device.place[i] += kCycle * (push[i] + device.hand_stiffness * (device.hand_at[i] - device.place[i])) /
                       device.hand_damping;
}

void listen_to_the_file(unsigned long every = 1) {
  const char* path = std::getenv("DHD_STUB_STATE");
  if (path == nullptr || all().looks++ % every != 0) return;
  std::ifstream in(path);
  DhdStubDevice& device = all().devices[0];
  const std::lock_guard lock(device.guard);
  device.plugged = device.powered = true;
  device.reset = device.controller_error = false;
  device.buttons = 0;
  device.hand = false;
  device.mirrored_axis = device.exchanged[0] = device.exchanged[1] = 0;
  std::string word;
  while (in >> word) {
    if (word == "unplugged") device.plugged = false;
    if (word == "unpowered") device.powered = false;
    if (word == "reset") device.reset = true;
    if (word == "error") device.controller_error = true;
    if (word == "button") {
      switch_off(device, kButtonCause);
      device.off_cause = kButtonCause;
    }
    if (word == "place") in >> device.place[0] >> device.place[1] >> device.place[2];
    if (word == "hand")
      device.hand = static_cast<bool>(in >> device.hand_at[0] >> device.hand_at[1] >> device.hand_at[2]);
    if (word == "axis") in >> device.mirrored_axis;
    if (word == "exchanged") in >> device.exchanged[0] >> device.exchanged[1];
    if (word == "pressed") {
      unsigned button = 0;
      if (in >> button && button > 0) device.buttons |= 1u << (button - 1);
    }
  }
}

DhdStubDevice* device_of(char id) {
  if (id < 0 || id >= kDevices) return nullptr;
  return &all().devices[static_cast<std::size_t>(id)];
}

// The device of an id, locked, if it is open and there; null and an error otherwise.
struct Held {
  explicit Held(char id) : device(device_of(id)) {
    listen_to_the_file(32);
    if (device == nullptr) {
      fail("device id is unknown");
      return;
    }
    lock = std::unique_lock(device->guard);
    if (!device->open || !device->plugged) {
      fail(device->open ? "communication error" : "device not ready");
      device = nullptr;
      return;
    }
    pass_time(*device);
  }
  explicit operator bool() const { return device != nullptr; }
  DhdStubDevice* operator->() const { return device; }
  DhdStubDevice* device;
  std::unique_lock<std::mutex> lock;
};

[[maybe_unused]] const bool kFurnished = (furnish(), true);

}  // namespace

extern "C" {

DhdStubDevice* dhd_stub_device(int number) { return device_of(static_cast<char>(number)); }

void dhd_stub_reset() {
  for (auto& device : all().devices) {
    device.~DhdStubDevice();
    new (&device) DhdStubDevice;
  }
  all().expert = false;
  furnish();
}

const char* dhdErrorGetLastStr() { return last_error; }

void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
  *major = 3;
  *minor = 17;
  *release = 5;
  *revision = 99;
}

int dhdGetDeviceCount() {
  listen_to_the_file();
  int count = 0;
  for (auto& device : all().devices) {
    const std::lock_guard lock(device.guard);
    if (device.plugged) ++count;
  }
  return count;
}

int dhdOpenID(char index) {
  int at = 0;
  for (int i = 0; i < kDevices; ++i) {
    DhdStubDevice& device = all().devices[static_cast<std::size_t>(i)];
    const std::lock_guard lock(device.guard);
    if (!device.plugged || at++ != index) continue;
    if (device.in_use) return fail("device is in use");
    if (!device.open) ++device.times_opened;
    device.open = true;
    return i;
  }
  return fail("no device found");
}

int dhdClose(char id) {
  DhdStubDevice* device = device_of(id);
  if (device == nullptr) return fail("device id is unknown");
  const std::lock_guard lock(device->guard);
  switch_off(*device, kSoftwareCause);
  device->open = false;
  return 0;
}

int dhdGetSystemType(char id) {
  const Held device(id);
  return device ? device->type : -1;
}

const char* dhdGetSystemName(char id) {
  const Held device(id);
  return device ? device->name : nullptr;
}

int dhdGetSerialNumber(unsigned short* number, char id) {
  const Held device(id);
  if (!device) return -1;
  *number = device->serial;
  return 0;
}

int dhdGetStatus(int* status, char id) {
  DhdStubDevice* device = device_of(id);
  if (device == nullptr || !device->open) return fail("device not ready");
  const std::lock_guard lock(device->guard);
  pass_time(*device);
  std::fill_n(status, static_cast<int>(kStatusCount), 0);
  status[kPower] = device->powered;
  status[kConnected] = device->plugged;
  status[kStarted] = 1;
  status[kReset] = device->reset;
  status[kForce] = device->forces_on;
  status[kBrake] = !device->forces_on;
  status[kWristDetected] = device->wrist;
  status[kWristInit] = device->wrist && device->wrist_initialised;
  status[kError] = device->controller_error;
  status[kGravity] = 1;
  status[kForceOffCause] = device->off_cause;
  return 0;
}

int dhdEnableForce(unsigned char on, char id) {
  const Held device(id);
  if (!device) return -1;
  if (on == 0) {
    switch_off(*device.device, kSoftwareCause);
    return 0;
  }
  if (!device->powered) return 0;
  device->forces_on = true;
  device->off_cause = 0;
  device->commanded_at_s = now_s(*device.device);
  return 0;
}

int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double rotation[3][3], char id) {
  const Held device(id);
  if (!device) return -1;
  *x = device->place[0];
  *y = device->place[1];
  *z = device->place[2];
  std::memcpy(rotation, device->rotation, sizeof device->rotation);
  return 1;  // "time guard": not new, which is no error
}

int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz,
                                        double grip, char id) {
  const Held device(id);
  if (!device) return -1;
  device->commanded_at_s = now_s(*device.device);
  ++device->commands;
  const double norm = std::sqrt(fx * fx + fy * fy + fz * fz);
  const double limit =
      device->max_force >= 0.0 ? std::min(device->max_force, device->strength) : device->strength;
  const double share = norm > limit ? limit / norm : 1.0;
  const double asked[3] = {fx, fy, fz}, others[4] = {tx, ty, tz, grip};
  std::copy_n(others, 4, device->other);
  if (device->forces_on) {
    for (int i = 0; i < 3; ++i) device->force[i] = share * asked[i];
    device->largest_force = std::max(device->largest_force, share * norm);
  }
  hold(*device.device);
  return device->forces_on && share < 1.0 ? 2 : 0;
}

#ifndef DHD_STUB_WITHOUT_BUTTONS
unsigned int dhdGetButtonMask(char id) {
  const Held device(id);
  return device ? device->buttons : 0;
}
#endif

#ifndef DHD_STUB_OLD
bool dhdHasWrist(char id) {
  const Held device(id);
  return device && device->wrist;
}

bool dhdIsLeftHanded(char) { return false; }

double dhdGetMaxForce(char id) {
  const Held device(id);
  return device ? device->max_force : -1.0;
}

int dhdEnableExpertMode() {
  all().expert = true;
  return 0;
}

int dhdDisableExpertMode() {
  all().expert = false;
  return 0;
}

int dhdSetWatchdog(unsigned char units, char id) {
  const Held device(id);
  if (!device) return -1;
  if (!all().expert) return fail("expert mode disabled");
  if (!device->has_watchdog) return fail("operation not available");
  device->watchdog_s = units * 125e-6;
  return 0;
}
#endif

}  // extern "C"
