// A stand-in for the maker's libHD.so with simulated devices, in the same binary interface.
//
// Written from the documented behaviour, with its own values and types: a mistake in the driver's
// declarations shows here. Forces are turned into torques by finite differences of the device's own forward
// kinematics.
#include "drivers/openhaptics/stub/hd_stub.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "drivers/openhaptics/stub/arm_line.h"

#ifdef HD_STUB_NEEDS_IO
extern "C" int hd_stub_io();
#endif

typedef unsigned int HHD;
typedef unsigned int HDenum;
struct HDErrorInfo {
  unsigned int errorCode;
  int internalErrorCode;
  HHD hHD;
};
typedef unsigned int (*HDSchedulerCallback)(void*);

namespace {

constexpr HHD kNone = 0xFFFFFFFFu;
constexpr int kDevices = 3;

struct Scheduled {
  unsigned long handle;
  HDSchedulerCallback callback;
  void* data;
};

struct Everything {
  std::array<HdStubDevice, kDevices> devices;
  std::atomic<HHD> current{kNone};
  std::mutex errors_guard;
  std::vector<HDErrorInfo> errors;
  std::mutex scheduled_guard;  // held while callbacks run: unscheduling waits for them
  std::vector<Scheduled> scheduled;
  unsigned long next_handle = 1;
  std::thread scheduler;
  std::atomic<bool> running{false}, frozen{false};
  hd_stub::ArmLine arm;
  std::array<Eigen::Vector3d, kDevices> asked{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                              Eigen::Vector3d::Zero()};
  Everything() { name_devices(); }
  void name_devices() {
    static const char* const kNames[kDevices] = {"Default Device", "Left", "Right"};
    for (std::size_t i = 0; i < kDevices; ++i) devices[i].name = kNames[i];
  }
};

Everything& all() {
  static auto* everything = new Everything;  // outlives every thread
  return *everything;
}

void fail(unsigned code) {
  const std::lock_guard lock(all().errors_guard);
  all().errors.push_back({code, static_cast<int>(code) + 1, all().current.load()});
}

HdStubDevice* device_of(HHD handle) { return handle < kDevices ? &all().devices[handle] : nullptr; }

HdStubDevice* current_device() {
  HdStubDevice* device = device_of(all().current.load());
  if (device == nullptr) fail(0x0104);
  return device;
}

Eigen::Matrix3d about_y(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
}
Eigen::Matrix3d about_x(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
}

// Turret, then a thigh that points towards the user, then a shin that hangs down from it; mm.
Eigen::Vector3d place_of(const HdStubDevice& device, const Eigen::Vector3d& turned) {
  const Eigen::Vector3d thigh = about_x(-turned[1]) * Eigen::Vector3d(0.0, 0.0, device.link_1_mm);
  const Eigen::Vector3d shin = about_x(-turned[2]) * Eigen::Vector3d(0.0, -device.link_2_mm, 0.0);
  return about_y(turned[0]) * (thigh + shin) + Eigen::Vector3d(0.0, device.link_2_mm, -device.link_1_mm) +
         Eigen::Vector3d(device.origin_mm);
}

Eigen::Vector3d torque_of(const HdStubDevice& device, const Eigen::Vector3d& force) {
  constexpr double kStep = 1e-5;
  const Eigen::Vector3d turned(device.turned);
  Eigen::Vector3d torque;
  for (int joint = 0; joint < 3; ++joint) {
    Eigen::Vector3d ahead = turned, behind = turned;
    ahead[joint] += kStep;
    behind[joint] -= kStep;
    torque[joint] = 1e-3 * force.dot(place_of(device, ahead) - place_of(device, behind)) / (2.0 * kStep);
  }
  return torque;
}

void give(HdStubDevice& device, const Eigen::Vector3d& force) {
  Eigen::Map<Eigen::Vector3d>(device.force) = force;
  Eigen::Vector3d axes = force;
  if (device.mirrored_axis > 0) axes[device.mirrored_axis - 1] *= -1.0;
  Eigen::Vector3d torque = torque_of(device, axes);
  if (device.exchanged[0] > 0) std::swap(torque[device.exchanged[0] - 1], torque[device.exchanged[1] - 1]);
  Eigen::Map<Eigen::Vector3d>(device.torque) = torque.cwiseProduct(Eigen::Vector3d(device.torque_gain));
  device.largest_force = std::max(device.largest_force, force.norm());
}

// A cycle of a hand on the stylus, a spring and a damper without mass: the tip's way is that of the joints.
void hold(HdStubDevice& device) {
  if (!device.hand) return;
  constexpr double kStep = 1e-5, kCycle = 1e-3;
  Eigen::Map<Eigen::Vector3d> turned(device.turned);
  Eigen::Matrix3d J;  // m / rad
  for (int joint = 0; joint < 3; ++joint) {
    Eigen::Vector3d ahead = turned, behind = turned;
    ahead[joint] += kStep;
    behind[joint] -= kStep;
    J.col(joint) = 1e-3 * (place_of(device, ahead) - place_of(device, behind)) / (2.0 * kStep);
  }
  const Eigen::Vector3d motors = J.transpose().inverse() * Eigen::Vector3d(device.torque);
  const Eigen::Vector3d off =
      1e-3 * (place_of(device, Eigen::Vector3d(device.hand_at)) - place_of(device, turned));
  const Eigen::Vector3d velocity = (motors + device.hand_stiffness * off) / device.hand_damping;
  turned += J.inverse() * (kCycle * velocity);
}

void listen_to_the_file() {
  const char* path = std::getenv("HD_STUB_STATE");
  if (path == nullptr) return;
  std::ifstream in(path);
  std::string word;
  bool unplugged = false;
  unsigned error = 0;
  HdStubDevice told;  // its hand, buttons and motors
  while (in >> word) {
    unplugged = unplugged || word == "unplugged";
    if (word == "hand")
      told.hand = static_cast<bool>(in >> told.hand_at[0] >> told.hand_at[1] >> told.hand_at[2]);
    if (word == "button") {
      unsigned button = 0;
      if (in >> button && button > 0) told.buttons |= 1u << (button - 1);
    }
    if (word == "axis") in >> told.mirrored_axis;
    if (word == "exchanged") in >> told.exchanged[0] >> told.exchanged[1];
    if (word == "torques") in >> told.torque_gain[0] >> told.torque_gain[1] >> told.torque_gain[2];
    if (word == "warm") error = 0x0200;
    if (word == "over") error = 0x0201;
  }
  for (auto& device : all().devices) {
    const std::lock_guard lock(device.guard);
    device.plugged = !unplugged;
    device.buttons = told.buttons;
    device.hand = told.hand;
    device.mirrored_axis = told.mirrored_axis;
    std::copy_n(told.hand_at, 3, device.hand_at);
    std::copy_n(told.exchanged, 2, device.exchanged);
    std::copy_n(told.torque_gain, 3, device.torque_gain);
    device.error = error;
    device.error_cycles = error != 0 ? 1000000 : 0;
  }
}

// False where no new reading has come: a cycle is one of the arm's.
bool take_reading() {
  constexpr int kLongest = 5;  // ms
  hd_stub::ArmReading reading;
  const bool taken = all().arm.take(reading, kLongest), there = all().arm.is_open();
  HdStubDevice& device = all().devices[0];
  const std::lock_guard lock(device.guard);
  device.plugged = there;
  if (!taken) return !there;
  std::copy_n(reading.turned, 3, device.turned);
  std::copy_n(reading.gimbal, 3, device.gimbal);
  device.buttons = reading.buttons;
  return true;
}

void schedule() {
  all().arm.hurry();
  auto next = std::chrono::steady_clock::now();
  for (int cycle = 0; all().running.load(); ++cycle) {
    if (cycle % 16 == 0) listen_to_the_file();
    if (all().arm.named() && !take_reading()) continue;
    if (!all().frozen.load()) {
      const std::lock_guard lock(all().scheduled_guard);
      auto& list = all().scheduled;
      for (std::size_t i = 0; i < list.size();)
        if (list[i].callback(list[i].data) == 0) {
          list.erase(list.begin() + static_cast<std::ptrdiff_t>(i));
        } else {
          ++i;
        }
    }
    if (all().arm.is_open()) continue;
    next = std::max(next + std::chrono::milliseconds(1),
                    std::chrono::steady_clock::now() - std::chrono::milliseconds(5));
    std::this_thread::sleep_until(next);
  }
}

}  // namespace

extern "C" {

HdStubDevice* hd_stub_device(int number) { return device_of(static_cast<HHD>(number)); }

void hd_stub_reset() {
  const std::lock_guard errors(all().errors_guard);
  all().errors.clear();
  all().frozen = false;
  for (int i = 0; i < kDevices; ++i) {
    HdStubDevice& device = all().devices[static_cast<std::size_t>(i)];
    device.~HdStubDevice();
    new (&device) HdStubDevice;
    all().asked[static_cast<std::size_t>(i)].setZero();
  }
  all().name_devices();
}

void hd_stub_freeze(bool frozen) { all().frozen = frozen; }
int hd_stub_schedulers() { return all().running ? 1 : 0; }

HHD hdInitDevice(const char* name) {
#ifdef HD_STUB_NEEDS_IO
  if (hd_stub_io() != 42) return kNone;
#endif
  listen_to_the_file();
  for (int i = 0; i < kDevices; ++i) {
    HdStubDevice& device = all().devices[static_cast<std::size_t>(i)];
    const std::lock_guard lock(device.guard);
    if (i == 0 ? (name != nullptr && std::strcmp(name, "Default Device") != 0)
               : (name == nullptr || std::strcmp(name, device.name) != 0))
      continue;
    if (i == 0 && all().arm.named()) device.plugged = all().arm.reach();
    unsigned error = device.init_error;
    if (!device.plugged) error = 0x0300;
    if (device.open) error = 0x0301;
    if (error != 0) {
      fail(error);
      return kNone;
    }
    device.open = true;
    ++device.times_opened;
    all().current = static_cast<HHD>(i);
    return static_cast<HHD>(i);
  }
  fail(0x0300);
  return kNone;
}

void hdDisableDevice(HHD handle) {
  HdStubDevice* device = device_of(handle);
  if (device == nullptr) return fail(0x0104);
  const std::lock_guard lock(device->guard);
  device->open = false;
  give(*device, Eigen::Vector3d::Zero());
}

void hdMakeCurrentDevice(HHD handle) {
  if (device_of(handle) == nullptr) return fail(0x0104);
  all().current = handle;
}

void hdBeginFrame(HHD handle) {
  HdStubDevice* device = device_of(handle);
  if (device == nullptr) return fail(0x0104);
  all().current = handle;
  std::unique_lock lock(device->guard);
  device->inside_begin = true;
  while (device->blocked) {
    lock.unlock();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    lock.lock();
  }
  device->inside_begin = false;
  if (!device->open) fail(0x0104);
  if (!device->plugged) fail(0x0302);
}

void hdEndFrame(HHD handle) {
  HdStubDevice* device = device_of(handle);
  if (device == nullptr) return fail(0x0104);
  const std::lock_guard lock(device->guard);
  Eigen::Vector3d force = all().asked[handle];
  if (!device->plugged) force.setZero();
  if (force.norm() > device->true_force * (1.0 + 1e-9)) {
    force.setZero();
    fail(0x0201);
  }
  if (device->error_cycles > 0) {
    --device->error_cycles;
    force.setZero();
    fail(device->error);
  }
  give(*device, force);
  hold(*device);
  if (handle == 0) all().arm.give({{device->force[0], device->force[1], device->force[2]}});
  ++device->cycles;
}

HDErrorInfo hdGetError() {
  const std::lock_guard lock(all().errors_guard);
  if (all().errors.empty()) return {0, 0, kNone};
  const HDErrorInfo newest = all().errors.back();
  all().errors.pop_back();
  return newest;
}

void hdEnable(HDenum capability) {
  if (capability != 0x4000) fail(0x0100);
}

void hdGetIntegerv(HDenum what, int* values) {
  HdStubDevice* device = current_device();
  if (device == nullptr) return;
  const std::lock_guard lock(device->guard);
  if (what == 0x2000) {
    *values = static_cast<int>(device->buttons);
  } else if (what == 0x2553) {
    *values = device->input_dof;
  } else if (what == 0x2554) {
    *values = 3;
  } else if (what == 0x2555) {
    *values = device->calibration_style;
  } else {
    fail(0x0100);
  }
}

void hdGetDoublev(HDenum what, double* values) {
  HdStubDevice* device = current_device();
  if (device == nullptr) return;
  const std::lock_guard lock(device->guard);
  const Eigen::Vector3d turned(device->turned);
  if (what == 0x2100) {
    Eigen::Map<Eigen::Vector3d> readings(values);
    readings = turned;
    if (device->turret_left) readings[0] = -turned[0];
    if (device->slipped) readings[1] = 0.0;
    if (device->joints_broken) readings[1] = std::nan("");
  } else if (what == 0x2052) {
    // The stylus on the forearm: right, up, clockwise as the user sees it from behind.
    const Eigen::Matrix3d stylus =
        about_y(turned[0]) * about_x(-turned[2]) * about_y(device->gimbal[0]) * about_x(-device->gimbal[1]) *
        Eigen::AngleAxisd(-device->gimbal[2], Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    pose.topLeftCorner<3, 3>() = stylus;
    pose.topRightCorner<3, 1>() = place_of(*device, turned);
    Eigen::Map<Eigen::Matrix4d> out(values);  // column by column
    out = pose;
  } else if (what == 0x2603) {
    *values = device->nominal_force;
  } else if (what == 0x2604) {
    *values = device->nominal_continuous;
  } else {
    fail(0x0100);
  }
}

const char* hdGetString(HDenum what) {
  switch (what) {
    case 0x2500:
      return "3.4.0";
    case 0x2501:
      return "Simulated PHANToM";
    case 0x2502:
      return "1.0";
    case 0x2504:
      return current_device() != nullptr ? current_device()->serial : "";
    default:
      fail(0x0100);
      return "";
  }
}

void hdSetDoublev(HDenum what, const double* values) {
  if (what != 0x2700) return fail(0x0100);
  if (current_device() != nullptr) all().asked[all().current.load()] = Eigen::Vector3d(values);
}

void hdStartScheduler() {
  if (all().running.exchange(true)) return;
  all().scheduler = std::thread(schedule);
}

void hdStopScheduler() {
  if (!all().running.exchange(false)) return;
  all().scheduler.join();
  for (auto& device : all().devices) {
    const std::lock_guard lock(device.guard);
    give(device, Eigen::Vector3d::Zero());
  }
}

unsigned long hdScheduleAsynchronous(HDSchedulerCallback callback, void* data, unsigned short) {
  const std::lock_guard lock(all().scheduled_guard);
  all().scheduled.push_back({all().next_handle, callback, data});
  return all().next_handle++;
}

void hdUnschedule(unsigned long handle) {
  const std::lock_guard lock(all().scheduled_guard);
  auto& list = all().scheduled;
  for (auto at = list.begin(); at != list.end(); ++at)
    if (at->handle == handle) {
      list.erase(at);
      return;
    }
  fail(0x0101);
}

#ifndef HD_STUB_WITHOUT_CALIBRATION
HDenum hdCheckCalibration() {
  HdStubDevice* device = current_device();
  if (device == nullptr) return 0x5002;
  const std::lock_guard lock(device->guard);
  return device->calibration;
}

void hdUpdateCalibration(HDenum style) {
  HdStubDevice* device = current_device();
  if (device == nullptr) return;
  const std::lock_guard lock(device->guard);
  if ((static_cast<HDenum>(device->calibration_style) & style) == 0) return fail(0x0101);
  ++device->times_calibrated;
  device->calibrated_under_force =
      device->calibrated_under_force || Eigen::Vector3d(device->force).norm() > 0.0;
  device->calibration = 0x5000;
}
#endif

}  // extern "C"
