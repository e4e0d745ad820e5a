#include "palpate/headset/internal/openxr_instance.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "palpate/core/text.h"

namespace palpate::headset {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;

// What we cannot do without.
constexpr std::array kExtensions{XR_KHR_OPENGL_ENABLE_EXTENSION_NAME, XR_MNDX_EGL_ENABLE_EXTENSION_NAME,
                                 XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME};

tl::unexpected<Error> no_runtime(const char* what, XrResult result) {
  if (result == XR_ERROR_RUNTIME_UNAVAILABLE)
    return refused(
        ErrorCode::not_found,
        "headset: no OpenXR runtime is there ({}); install the headset's, or Monado, and make it the active "
        "one (~/.config/openxr/1/active_runtime.json) or name it in XR_RUNTIME_JSON",
        name_of(result));
  return refused(ErrorCode::not_found,
                 "headset: the OpenXR runtime does not answer ({}: {}); start it (Monado: monado-service)",
                 what, name_of(result));
}

Expected<void> look_for_extensions() {
  std::uint32_t count = 0;
  XrResult result = xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr);
  if (XR_FAILED(result)) return no_runtime("xrEnumerateInstanceExtensionProperties", result);
  std::vector<XrExtensionProperties> offered(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 0});
  result = xrEnumerateInstanceExtensionProperties(nullptr, count, &count, offered.data());
  if (XR_FAILED(result)) return no_runtime("xrEnumerateInstanceExtensionProperties", result);
  for (const char* wanted : kExtensions) {
    const bool there = std::any_of(offered.begin(), offered.end(), [wanted](const auto& one) {
      return std::strcmp(one.extensionName, wanted) == 0;
    });
    if (!there)
      return refused(
          "headset: the OpenXR runtime does not offer {}, which is expected; use one that does (Monado, "
          "WiVRn)",
          wanted);
  }
  return {};
}

template <typename Function>
bool find(XrInstance instance, const char* name, Function& function) {
  return XR_SUCCEEDED(
      xrGetInstanceProcAddr(instance, name, reinterpret_cast<PFN_xrVoidFunction*>(&function)));
}

}  // namespace

Expected<std::unique_ptr<OpenXrInstance>> OpenXrInstance::open() {
  if (auto offered = look_for_extensions(); !offered) return tl::unexpected(offered.error());
  XrInstanceCreateInfo info{};
  info.type = XR_TYPE_INSTANCE_CREATE_INFO;
  std::strcpy(info.applicationInfo.applicationName, "Palpate");
  std::strcpy(info.applicationInfo.engineName, "Palpate");
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  info.enabledExtensionCount = static_cast<std::uint32_t>(kExtensions.size());
  info.enabledExtensionNames = kExtensions.data();
  std::unique_ptr<OpenXrInstance> opened(new OpenXrInstance());
  if (const XrResult result = xrCreateInstance(&info, &opened->instance_); XR_FAILED(result)) {
    opened->instance_ = XR_NULL_HANDLE;
    return no_runtime("xrCreateInstance", result);
  }
  if (auto found = opened->find_functions(); !found) return tl::unexpected(found.error());
  XrInstanceProperties properties{};
  properties.type = XR_TYPE_INSTANCE_PROPERTIES;
  if (const XrResult result = xrGetInstanceProperties(opened->instance_, &properties); XR_FAILED(result))
    return failed("xrGetInstanceProperties", result);
  const XrVersion version = properties.runtimeVersion;
  opened->runtime_ = fmt::format("{} {}.{}.{}", excerpt(properties.runtimeName), XR_VERSION_MAJOR(version),
                                 XR_VERSION_MINOR(version), XR_VERSION_PATCH(version));
  if (auto found = opened->find_headset(); !found) return tl::unexpected(found.error());
  return opened;
}

OpenXrInstance::~OpenXrInstance() {
  if (instance_ != XR_NULL_HANDLE) xrDestroyInstance(instance_);
}

Expected<void> OpenXrInstance::find_functions() {
  const bool found = find(instance_, "xrConvertTimespecTimeToTimeKHR", from_timespec_) &&
                     find(instance_, "xrConvertTimeToTimespecTimeKHR", to_timespec_) &&
                     find(instance_, "xrGetOpenGLGraphicsRequirementsKHR", requirements_);
  if (!found) return refused("headset: the OpenXR runtime lacks a function of an extension that it offers");
  return {};
}

Expected<void> OpenXrInstance::find_headset() {
  XrSystemGetInfo wanted{};
  wanted.type = XR_TYPE_SYSTEM_GET_INFO;
  wanted.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  const XrResult result = xrGetSystem(instance_, &wanted, &system_);
  if (result == XR_ERROR_FORM_FACTOR_UNAVAILABLE || result == XR_ERROR_FORM_FACTOR_UNSUPPORTED)
    return refused(ErrorCode::not_found,
                   "headset: the OpenXR runtime ({}) has no headset ({}); plug it in and switch it on",
                   runtime_, name_of(result));
  if (XR_FAILED(result)) return failed("xrGetSystem", result);
  XrSystemProperties properties{};
  properties.type = XR_TYPE_SYSTEM_PROPERTIES;
  if (const XrResult asked = xrGetSystemProperties(instance_, system_, &properties); XR_FAILED(asked))
    return failed("xrGetSystemProperties", asked);
  device_ = excerpt(properties.systemName);
  return {};
}

Expected<void> OpenXrInstance::require_opengl() const {
  XrGraphicsRequirementsOpenGLKHR wanted{};
  wanted.type = XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR;
  if (const XrResult result = requirements_(instance_, system_, &wanted); XR_FAILED(result))
    return failed("xrGetOpenGLGraphicsRequirementsKHR", result);
  return {};
}

Expected<XrTime> OpenXrInstance::time_of(std::int64_t monotonic_ns) const {
  const timespec spec{static_cast<time_t>(monotonic_ns / kNsPerS), static_cast<long>(monotonic_ns % kNsPerS)};
  XrTime time = 0;
  if (const XrResult result = from_timespec_(instance_, &spec, &time); XR_FAILED(result))
    return failed("xrConvertTimespecTimeToTimeKHR", result);
  return time;
}

Expected<std::int64_t> OpenXrInstance::monotonic_of(XrTime time) const {
  timespec spec{};
  if (const XrResult result = to_timespec_(instance_, time, &spec); XR_FAILED(result))
    return failed("xrConvertTimeToTimespecTimeKHR", result);
  return static_cast<std::int64_t>(spec.tv_sec) * kNsPerS + spec.tv_nsec;
}

}  // namespace palpate::headset
