// An OpenXR runtime and the headset at it. One thread.
#pragma once

#include <memory>
#include <string>

#include "palpate/headset/internal/openxr.h"

namespace palpate::headset {

class OpenXrInstance {
 public:
  // Refused, with the remedy, where there is no runtime, it does not run, it lacks an extension, or has no headset.
  static Expected<std::unique_ptr<OpenXrInstance>> open();
  ~OpenXrInstance();
  OpenXrInstance(const OpenXrInstance&) = delete;
  OpenXrInstance& operator=(const OpenXrInstance&) = delete;

  XrInstance handle() const { return instance_; }
  XrSystemId system() const { return system_; }
  const std::string& runtime() const { return runtime_; }  // name and version
  const std::string& device() const { return device_; }
  // A function of the runtime's own library.
  void* code() const { return reinterpret_cast<void*>(from_timespec_); }
  // Has to be asked before a session is made.
  Expected<void> require_opengl() const;

  // CLOCK_MONOTONIC, ns, and the runtime's own time.
  Expected<XrTime> time_of(std::int64_t monotonic_ns) const;
  Expected<std::int64_t> monotonic_of(XrTime time) const;

 private:
  OpenXrInstance() = default;
  Expected<void> find_functions();
  Expected<void> find_headset();

  XrInstance instance_ = XR_NULL_HANDLE;
  XrSystemId system_ = XR_NULL_SYSTEM_ID;
  std::string runtime_, device_;
  PFN_xrConvertTimespecTimeToTimeKHR from_timespec_ = nullptr;
  PFN_xrConvertTimeToTimespecTimeKHR to_timespec_ = nullptr;
  PFN_xrGetOpenGLGraphicsRequirementsKHR requirements_ = nullptr;
};

}  // namespace palpate::headset
