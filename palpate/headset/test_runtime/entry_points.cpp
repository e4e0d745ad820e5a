// What OpenXR's loader finds in the test runtime: the functions of the specification, as far as Palpate may use them.
#include <algorithm>
#include <cstdio>
#include <cstring>

#include "runtime.h"

namespace palpate::headset {
namespace {

// The loader's side of a runtime, which Debian 12's headers leave out (OpenXR loader design document, "Negotiation").
struct LoaderInfo {
  int type;
  std::uint32_t version;
  std::size_t size;
  std::uint32_t min_interface, max_interface;
  XrVersion min_api, max_api;
};
struct RuntimeRequest {
  int type;
  std::uint32_t version;
  std::size_t size;
  std::uint32_t interface;
  XrVersion api;
  PFN_xrGetInstanceProcAddr find;
};
constexpr int kLoaderInfo = 1, kRuntimeRequest = 3;
constexpr std::uint32_t kInterface = 1;

Runtime& runtime() { return Runtime::the(); }

// Of every function but those that make or end an instance.
#define PALPATE_UNLESS_GONE \
  if (runtime().gone()) return XR_ERROR_INSTANCE_LOST

XrResult XRAPI_CALL enumerate_extensions(const char* layer, std::uint32_t capacity, std::uint32_t* count,
                                         XrExtensionProperties* properties) {
  if (layer != nullptr) return XR_ERROR_API_LAYER_NOT_PRESENT;
  std::vector<const char*> names{XR_KHR_OPENGL_ENABLE_EXTENSION_NAME};
  const auto refusal = runtime().refusal();
  if (refusal != TestRuntime::Refusal::no_egl) names.push_back(XR_MNDX_EGL_ENABLE_EXTENSION_NAME);
  if (refusal != TestRuntime::Refusal::no_times) names.push_back(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);
  *count = static_cast<std::uint32_t>(names.size());
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < names.size()) return XR_ERROR_SIZE_INSUFFICIENT;
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::snprintf(properties[i].extensionName, sizeof properties[i].extensionName, "%s", names[i]);
    properties[i].extensionVersion = 1;
  }
  return XR_SUCCESS;
}

XrResult XRAPI_CALL create_instance(const XrInstanceCreateInfo* info, XrInstance* instance) {
  if (info->type != XR_TYPE_INSTANCE_CREATE_INFO) return XR_ERROR_VALIDATION_FAILURE;
  return runtime().make_instance(instance);
}

XrResult XRAPI_CALL destroy_instance(XrInstance) {
  runtime().end_instance();
  return XR_SUCCESS;
}

XrResult XRAPI_CALL get_instance_properties(XrInstance, XrInstanceProperties* properties) {
  PALPATE_UNLESS_GONE;
  properties->runtimeVersion = XR_MAKE_VERSION(1, 2, 3);
  std::snprintf(properties->runtimeName, sizeof properties->runtimeName, "Palpate's test runtime");
  return XR_SUCCESS;
}

XrResult XRAPI_CALL poll_event(XrInstance, XrEventDataBuffer* event) {
  PALPATE_UNLESS_GONE;
  return runtime().next_event(*event);
}

XrResult XRAPI_CALL get_system(XrInstance, const XrSystemGetInfo* info, XrSystemId* system) {
  PALPATE_UNLESS_GONE;
  if (info->formFactor != XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY) return XR_ERROR_FORM_FACTOR_UNSUPPORTED;
  if (runtime().refusal() == TestRuntime::Refusal::no_headset) return XR_ERROR_FORM_FACTOR_UNAVAILABLE;
  *system = 1;
  return XR_SUCCESS;
}

XrResult XRAPI_CALL get_system_properties(XrInstance, XrSystemId system, XrSystemProperties* properties) {
  PALPATE_UNLESS_GONE;
  if (system != 1) return XR_ERROR_SYSTEM_INVALID;
  std::snprintf(properties->systemName, sizeof properties->systemName, "test headset");
  return XR_SUCCESS;
}

XrResult XRAPI_CALL enumerate_blend_modes(XrInstance, XrSystemId, XrViewConfigurationType,
                                          std::uint32_t capacity, std::uint32_t* count,
                                          XrEnvironmentBlendMode* modes) {
  PALPATE_UNLESS_GONE;
  *count = 1;
  if (capacity > 0) *modes = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
  return XR_SUCCESS;
}

XrResult XRAPI_CALL opengl_requirements(XrInstance, XrSystemId,
                                        XrGraphicsRequirementsOpenGLKHR* requirements) {
  PALPATE_UNLESS_GONE;
  runtime().requirements_asked();
  requirements->minApiVersionSupported = XR_MAKE_VERSION(3, 0, 0);
  requirements->maxApiVersionSupported = XR_MAKE_VERSION(4, 6, 0);
  return XR_SUCCESS;
}

XrResult XRAPI_CALL create_session(XrInstance, const XrSessionCreateInfo* info, XrSession* session) {
  PALPATE_UNLESS_GONE;
  return runtime().make_session(*info, session);
}

XrResult XRAPI_CALL destroy_session(XrSession) {
  runtime().end_session_object();
  return XR_SUCCESS;
}

XrResult XRAPI_CALL create_reference_space(XrSession, const XrReferenceSpaceCreateInfo* info,
                                           XrSpace* space) {
  PALPATE_UNLESS_GONE;
  return runtime().make_space(info->referenceSpaceType, space);
}

XrResult XRAPI_CALL destroy_space(XrSpace) { return XR_SUCCESS; }

XrResult XRAPI_CALL locate_space(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location) {
  PALPATE_UNLESS_GONE;
  return runtime().locate(space, base, time, *location);
}

XrResult XRAPI_CALL enumerate_formats(XrSession, std::uint32_t capacity, std::uint32_t* count,
                                      std::int64_t* formats) {
  PALPATE_UNLESS_GONE;
  std::vector<std::int64_t> offered{GL_RGBA8};
  if (runtime().refusal() != TestRuntime::Refusal::no_srgb) offered.push_back(0x8C43);  // GL_SRGB8_ALPHA8
  *count = static_cast<std::uint32_t>(offered.size());
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < offered.size()) return XR_ERROR_SIZE_INSUFFICIENT;
  std::copy(offered.begin(), offered.end(), formats);
  return XR_SUCCESS;
}

XrResult XRAPI_CALL create_swapchain(XrSession, const XrSwapchainCreateInfo* info, XrSwapchain* swapchain) {
  PALPATE_UNLESS_GONE;
  return runtime().make_swapchain(*info, swapchain);
}

XrResult XRAPI_CALL destroy_swapchain(XrSwapchain swapchain) { return runtime().end_swapchain(swapchain); }

XrResult XRAPI_CALL enumerate_images(XrSwapchain swapchain, std::uint32_t capacity, std::uint32_t* count,
                                     XrSwapchainImageBaseHeader* images) {
  PALPATE_UNLESS_GONE;
  return runtime().images(swapchain, capacity, count, images);
}

XrResult XRAPI_CALL acquire_image(XrSwapchain swapchain, const XrSwapchainImageAcquireInfo*,
                                  std::uint32_t* index) {
  PALPATE_UNLESS_GONE;
  return runtime().acquire(swapchain, index);
}

XrResult XRAPI_CALL wait_image(XrSwapchain swapchain, const XrSwapchainImageWaitInfo*) {
  PALPATE_UNLESS_GONE;
  return runtime().wait_image(swapchain);
}

XrResult XRAPI_CALL release_image(XrSwapchain swapchain, const XrSwapchainImageReleaseInfo*) {
  PALPATE_UNLESS_GONE;
  return runtime().release(swapchain);
}

XrResult XRAPI_CALL begin_session(XrSession, const XrSessionBeginInfo* info) {
  PALPATE_UNLESS_GONE;
  if (info->primaryViewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO)
    return XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED;
  return runtime().begin_session();
}

XrResult XRAPI_CALL end_session(XrSession) {
  PALPATE_UNLESS_GONE;
  return runtime().end_session();
}

XrResult XRAPI_CALL wait_frame(XrSession, const XrFrameWaitInfo*, XrFrameState* state) {
  PALPATE_UNLESS_GONE;
  return runtime().wait_frame(*state);
}

XrResult XRAPI_CALL begin_frame(XrSession, const XrFrameBeginInfo*) {
  PALPATE_UNLESS_GONE;
  return runtime().begin_frame();
}

XrResult XRAPI_CALL end_frame(XrSession, const XrFrameEndInfo* info) {
  PALPATE_UNLESS_GONE;
  return runtime().end_frame(*info);
}

XrResult XRAPI_CALL from_timespec(XrInstance, const timespec* spec, XrTime* time) {
  PALPATE_UNLESS_GONE;
  *time = static_cast<XrTime>(spec->tv_sec) * 1'000'000'000 + spec->tv_nsec + kXrTimeAhead_ns;
  return XR_SUCCESS;
}

XrResult XRAPI_CALL to_timespec(XrInstance, XrTime time, timespec* spec) {
  PALPATE_UNLESS_GONE;
  const std::int64_t ns = time - kXrTimeAhead_ns;
  *spec = {static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  return XR_SUCCESS;
}

struct Entry {
  const char* name;
  PFN_xrVoidFunction function;
};

template <typename Function>
PFN_xrVoidFunction plain(Function* function) {
  return reinterpret_cast<PFN_xrVoidFunction>(function);
}

XrResult XRAPI_CALL find(XrInstance, const char* name, PFN_xrVoidFunction* function) {
  static const Entry kEntries[] = {
      {"xrGetInstanceProcAddr", plain(find)},
      {"xrEnumerateInstanceExtensionProperties", plain(enumerate_extensions)},
      {"xrCreateInstance", plain(create_instance)},
      {"xrDestroyInstance", plain(destroy_instance)},
      {"xrGetInstanceProperties", plain(get_instance_properties)},
      {"xrPollEvent", plain(poll_event)},
      {"xrGetSystem", plain(get_system)},
      {"xrGetSystemProperties", plain(get_system_properties)},
      {"xrEnumerateEnvironmentBlendModes", plain(enumerate_blend_modes)},
      {"xrGetOpenGLGraphicsRequirementsKHR", plain(opengl_requirements)},
      {"xrCreateSession", plain(create_session)},
      {"xrDestroySession", plain(destroy_session)},
      {"xrCreateReferenceSpace", plain(create_reference_space)},
      {"xrDestroySpace", plain(destroy_space)},
      {"xrLocateSpace", plain(locate_space)},
      {"xrEnumerateSwapchainFormats", plain(enumerate_formats)},
      {"xrCreateSwapchain", plain(create_swapchain)},
      {"xrDestroySwapchain", plain(destroy_swapchain)},
      {"xrEnumerateSwapchainImages", plain(enumerate_images)},
      {"xrAcquireSwapchainImage", plain(acquire_image)},
      {"xrWaitSwapchainImage", plain(wait_image)},
      {"xrReleaseSwapchainImage", plain(release_image)},
      {"xrBeginSession", plain(begin_session)},
      {"xrEndSession", plain(end_session)},
      {"xrWaitFrame", plain(wait_frame)},
      {"xrBeginFrame", plain(begin_frame)},
      {"xrEndFrame", plain(end_frame)},
      {"xrConvertTimespecTimeToTimeKHR", plain(from_timespec)},
      {"xrConvertTimeToTimespecTimeKHR", plain(to_timespec)},
  };
  for (const Entry& entry : kEntries)
    if (std::strcmp(entry.name, name) == 0) {
      *function = entry.function;
      return XR_SUCCESS;
    }
  *function = nullptr;
  return XR_ERROR_FUNCTION_UNSUPPORTED;
}

}  // namespace
}  // namespace palpate::headset

extern "C" __attribute__((visibility("default"))) palpate::headset::TestRuntime* palpate_test_runtime() {
  return &palpate::headset::Runtime::the();
}

extern "C" __attribute__((visibility("default"))) XrResult XRAPI_CALL
xrNegotiateLoaderRuntimeInterface(const void* loader, void* request) {
  using namespace palpate::headset;
  const auto& info = *static_cast<const LoaderInfo*>(loader);
  auto& wanted = *static_cast<RuntimeRequest*>(request);
  if (info.type != kLoaderInfo || wanted.type != kRuntimeRequest || info.min_interface > kInterface ||
      info.max_interface < kInterface)
    return XR_ERROR_INITIALIZATION_FAILED;
  wanted.interface = kInterface;
  wanted.api = XR_MAKE_VERSION(1, 0, 20);
  wanted.find = find;
  return XR_SUCCESS;
}
