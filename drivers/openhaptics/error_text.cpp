#include "drivers/openhaptics/error_text.h"

namespace palpate::drivers::openhaptics {

ErrorWords error_text(hd::ErrorCode code) {
  constexpr auto kForce = ErrorKind::force;
  constexpr auto kDevice = ErrorKind::device;
  constexpr const char* kReport = "install OpenHaptics 3.0 or newer, the library may be of another version";
  switch (code) {
    case hd::kSuccess:
      return {ErrorKind::none, "HD_SUCCESS", "no error", ""};
    case hd::kInvalidEnum:
      return {kDevice, "HD_INVALID_ENUM", "the library does not know what it was asked for", kReport};
    case hd::kInvalidValue:
      return {kDevice, "HD_INVALID_VALUE", "the library refused a value", kReport};
    case hd::kInvalidOperation:
      return {kDevice, "HD_INVALID_OPERATION", "the library refused a call", kReport};
    case hd::kInvalidInputType:
      return {kDevice, "HD_INVALID_INPUT_TYPE", "the library refused a type", kReport};
    case hd::kBadHandle:
      return {kDevice, "HD_BAD_HANDLE", "the library has forgotten the device", "plug it in again"};
    case hd::kWarmMotors:
      return {kForce, "HD_WARM_MOTORS", "its motors are too warm",
              "let go and wait until they have cooled; weaker or shorter forces keep them cool"};
    case hd::kExceededMaxForce:
      return {kForce, "HD_EXCEEDED_MAX_FORCE", "the force was above what it can give",
              "set the peak of the force limits below the device's"};
    case hd::kExceededMaxForceImpulse:
      return {kForce, "HD_EXCEEDED_MAX_FORCE_IMPULSE", "the force changed faster than it allows",
              "set the slew of the force limits below the device's"};
    case hd::kExceededMaxVelocity:
      return {kForce, "HD_EXCEEDED_MAX_VELOCITY", "it was moved faster than it allows",
              "move the stylus more slowly"};
    case hd::kForceError:
      return {kForce, "HD_FORCE_ERROR", "it could not give the force",
              "let go of the stylus for a moment, and switch the device off and on if it stays"};
    case hd::kDeviceFault:
      return {kDevice, "HD_DEVICE_FAULT", "it does not answer, or reports a fault",
              "see that it has power and its cable is in, and that the maker's diagnostic program sees it"};
    case hd::kDeviceAlreadyInitiated:
      return {kDevice, "HD_DEVICE_ALREADY_INITIATED", "somebody has opened it already",
              "stop the other program, or name another device"};
    case hd::kCommError:
      return {kDevice, "HD_COMM_ERROR", "the connection to it broke",
              "see to its cable and power, and to the rights to its node in /dev (palpate doctor)"};
    case hd::kCommConfigError:
      return {kDevice, "HD_COMM_CONFIG_ERROR", "the connection is not set up as the library expects",
              "run the maker's setup program for this device as yourself, not with sudo"};
    case hd::kTimerError:
      return {kDevice, "HD_TIMER_ERROR", "the library's 1 kHz timer does not run",
              "give this user real-time rights (palpate doctor)"};
    case hd::kIllegalBegin:
      return {kDevice, "HD_ILLEGAL_BEGIN", "the library refused to begin a cycle", kReport};
    case hd::kIllegalEnd:
      return {kDevice, "HD_ILLEGAL_END", "the library refused to end a cycle", kReport};
    case hd::kFrameError:
      return {kForce, "HD_FRAME_ERROR", "a cycle of the library went wrong or took too long",
              "give this user real-time rights (palpate doctor)"};
    case hd::kInvalidPriority:
      return {kDevice, "HD_INVALID_PRIORITY", "the library refused the priority of its loop", kReport};
    case hd::kSchedulerFull:
      return {kDevice, "HD_SCHEDULER_FULL", "the library runs as many loops as it can",
              "stop what else in this process uses it"};
    case hd::kInvalidLicense:
      return {kDevice, "HD_INVALID_LICENSE", "the library has no valid licence",
              "install the maker's licence for OpenHaptics on this machine"};
    default:
      return {kDevice, "unknown", "an error that this driver does not know",
              "see the maker's list of error codes"};
  }
}

}  // namespace palpate::drivers::openhaptics
