// The part of OpenHaptics' device interface (HDAPI, libHD.so) that the driver calls: types, values and
// functions as the library has them in memory.
//
// Written from the publicly documented interface so that nothing of the maker's kit is needed to build; the
// functions are looked up by name at run time (library.h). Values are the maker's, units too: mm, N, radians.
// Frame of the library: x to the user's right, y up, z towards the user. Source: 3D Systems, OpenHaptics
// Toolkit API Reference Guide 3.4, "HDAPI".
#pragma once

namespace palpate::drivers::openhaptics::hd {

using Handle = unsigned int;
using Enum = unsigned int;
using ErrorCode = unsigned int;
using SchedulerHandle = unsigned long;
using Callback = unsigned int (*)(void* user_data);

struct ErrorInfo {
  ErrorCode code;
  int internal;   // of the device's own electronics
  Handle device;  // the current one when it happened
};
static_assert(sizeof(ErrorInfo) == 12);

inline constexpr Handle kInvalidHandle = 0xFFFFFFFFu;
inline constexpr unsigned int kCallbackDone = 0, kCallbackContinue = 1;
inline constexpr unsigned short kHighestPriority = 0xFFFF;

// What can be asked for or set.
inline constexpr Enum kCurrentButtons = 0x2000;  // an integer, the first button is bit 0
inline constexpr Enum kTransform = 0x2052;       // 16 doubles, a 4x4 matrix column by column, mm
inline constexpr Enum kJointAngles = 0x2100;
inline constexpr Enum kVersion = 0x2500, kModel = 0x2501, kDriverVersion = 0x2502, kSerialNumber = 0x2504;
inline constexpr Enum kInputDof = 0x2553, kOutputDof = 0x2554, kCalibrationStyle = 0x2555;
inline constexpr Enum kNominalMaxForce = 0x2603, kNominalMaxContinuousForce = 0x2604;  // N
inline constexpr Enum kForce = 0x2700;                                                 // 3 doubles, N
inline constexpr Enum kForceOutput = 0x4000;                                           // a capability

inline constexpr Enum kCalibrationOk = 0x5000, kCalibrationNeedsUpdate = 0x5001,
                      kCalibrationNeedsManualInput = 0x5002;
inline constexpr Enum kEncoderReset = 1, kAuto = 2, kInkwell = 4;  // bits of kCalibrationStyle

inline constexpr ErrorCode kSuccess = 0;
inline constexpr ErrorCode kInvalidEnum = 0x0100, kInvalidValue = 0x0101, kInvalidOperation = 0x0102,
                           kInvalidInputType = 0x0103, kBadHandle = 0x0104;
inline constexpr ErrorCode kWarmMotors = 0x0200, kExceededMaxForce = 0x0201,
                           kExceededMaxForceImpulse = 0x0202, kExceededMaxVelocity = 0x0203,
                           kForceError = 0x0204;
inline constexpr ErrorCode kDeviceFault = 0x0300, kDeviceAlreadyInitiated = 0x0301, kCommError = 0x0302,
                           kCommConfigError = 0x0303, kTimerError = 0x0304;
inline constexpr ErrorCode kIllegalBegin = 0x0400, kIllegalEnd = 0x0401, kFrameError = 0x0402;
inline constexpr ErrorCode kInvalidPriority = 0x0500, kSchedulerFull = 0x0501;
inline constexpr ErrorCode kInvalidLicense = 0x0600;

// The library's functions. No name: the default device.
struct Functions {
  Handle (*init_device)(const char* name);
  void (*disable_device)(Handle);
  void (*make_current_device)(Handle);
  void (*begin_frame)(Handle);
  void (*end_frame)(Handle);
  ErrorInfo (*get_error)();  // newest first; code kSuccess: none is left
  void (*enable)(Enum);
  void (*get_integerv)(Enum, int*);
  void (*get_doublev)(Enum, double*);
  const char* (*get_string)(Enum);
  void (*set_doublev)(Enum, const double*);
  void (*start_scheduler)();
  void (*stop_scheduler)();
  SchedulerHandle (*schedule_asynchronous)(Callback, void* user_data, unsigned short priority);
  void (*unschedule)(SchedulerHandle);
  Enum (*check_calibration)();
  void (*update_calibration)(Enum style);
};

}  // namespace palpate::drivers::openhaptics::hd
