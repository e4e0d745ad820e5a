// OpenXR's headers with what we use of them, and its results as words. Nothing else includes them.
#pragma once

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <time.h>

#define XR_USE_PLATFORM_EGL
#define XR_USE_GRAPHICS_API_OPENGL
#define XR_USE_TIMESPEC
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "palpate/core/expected.h"
#include "palpate/math/pose.h"

namespace palpate::headset {

const char* name_of(XrResult result);
// "headset: xrBeginSession: XR_ERROR_...", with the code `disconnected` where the runtime or the session has gone.
tl::unexpected<Error> failed(const char* what, XrResult result);

XrPosef to_xr(const Quaternion& rotation, const Vector3& translation);

template <typename A, typename B>
XrPosef to_xr(const Pose<A, B>& pose) {
  return to_xr(pose.rotation, pose.translation);
}
template <typename A, typename B>
Pose<A, B> from_xr(const XrPosef& pose) {
  const auto& q = pose.orientation;
  const auto& p = pose.position;
  return {Quaternion(q.w, q.x, q.y, q.z).normalized(), Vector3(p.x, p.y, p.z)};
}

}  // namespace palpate::headset
