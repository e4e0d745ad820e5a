#include "palpate/headset/internal/openxr.h"

#include <openxr/openxr_reflection.h>

namespace palpate::headset {

const char* name_of(XrResult result) {
  switch (result) {
#define PALPATE_XR_NAME(name, value) \
  case name:                         \
    return #name;
    XR_LIST_ENUM_XrResult(PALPATE_XR_NAME)
#undef PALPATE_XR_NAME
        default : return "an unknown result";
  }
}

tl::unexpected<Error> failed(const char* what, XrResult result) {
  const bool gone = result == XR_ERROR_INSTANCE_LOST || result == XR_ERROR_SESSION_LOST ||
                    result == XR_SESSION_LOSS_PENDING;
  return refused(gone ? ErrorCode::disconnected : ErrorCode::unspecified, "headset: {}: {}", what,
                 name_of(result));
}

XrPosef to_xr(const Quaternion& rotation, const Vector3& translation) {
  XrPosef pose{};
  pose.orientation = {static_cast<float>(rotation.x()), static_cast<float>(rotation.y()),
                      static_cast<float>(rotation.z()), static_cast<float>(rotation.w())};
  pose.position = {static_cast<float>(translation.x()), static_cast<float>(translation.y()),
                   static_cast<float>(translation.z())};
  return pose;
}

}  // namespace palpate::headset
