// The part of Force Dimension's device interface (DHD) that the driver calls: types, values and functions as the library
// has them in memory.
//
// Written from the published interface so that nothing of the maker's kit is needed to build; the functions are looked up
// by name at run time (library.h). Units are the maker's: m, N, N m, radians. Frame of the library: the device's own
// right-handed axes, x from the device towards the user, y to the user's right, z up. Unless said otherwise a function
// gives 0, or a positive remark, where all is well, and -1 where it is not. `id` is that of an open device. Source: Force
// Dimension, DHD/DRD SDK 3.17, "dhdc.h" and its reference manual.
#pragma once

namespace palpate::drivers::forcedimension::dhd {

// What dhdGetSystemType gives.
inline constexpr int kTypeNone = 0, kTypeDelta3 = 63, kTypeFalcon = 60;
inline constexpr int kTypeController = 81, kTypeControllerHr = 82;

// A remark of set_force...: the motors cannot give so much.
inline constexpr int kMotorSaturated = 2;

// What dhdGetStatus fills in; newer versions have more than older ones, none more than kMostStatus.
inline constexpr int kMostStatus = 32;
inline constexpr int kPower = 0, kConnected = 1, kReset = 3, kForce = 5, kWristDetected = 8, kError = 9,
                     kGravity = 10, kWristInit = 12, kForceOffCause = 14;
// Of kForceOffCause.
inline constexpr int kOffNot = 0, kOffButton = 1, kOffVelocity = 2, kOffWatchdog = 3, kOffSoftware = 4,
                     kOffDeadMan = 6;

// The unit of dhdSetWatchdog, s.
inline constexpr double kWatchdogUnit = 125e-6;

struct Functions {
  int (*get_device_count)();
  int (*open_id)(char index);  // gives an id
  int (*close)(char id);
  int (*get_system_type)(char id);
  const char* (*get_system_name)(char id);
  int (*get_serial_number)(unsigned short* number, char id);
  void (*get_sdk_version)(int* major, int* minor, int* release, int* revision);
  int (*get_status)(int* status, char id);
  int (*enable_force)(unsigned char on, char id);
  int (*get_pose)(double* x, double* y, double* z, double rotation[3][3], char id);
  unsigned int (*get_button_mask)(char id);
  int (*set_force)(double fx, double fy, double fz, double tx, double ty, double tz, double grip, char id);
  const char* (*get_last_error)();  // of this thread
  // Null in older versions.
  bool (*has_wrist)(char id);
  bool (*is_left_handed)(char id);
  double (*get_max_force)(char id);  // negative: not limited
  int (*enable_expert_mode)();
  int (*disable_expert_mode)();
  int (*set_watchdog)(unsigned char units, char id);
};

}  // namespace palpate::drivers::forcedimension::dhd
