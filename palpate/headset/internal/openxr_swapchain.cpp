#include "palpate/headset/internal/openxr_swapchain.h"

#include <algorithm>

namespace palpate::headset {

Expected<void> look_for_format(XrSession session) {
  std::uint32_t count = 0;
  if (const XrResult result = xrEnumerateSwapchainFormats(session, 0, &count, nullptr); XR_FAILED(result))
    return failed("xrEnumerateSwapchainFormats", result);
  std::vector<std::int64_t> formats(count);
  if (const XrResult result = xrEnumerateSwapchainFormats(session, count, &count, formats.data());
      XR_FAILED(result))
    return failed("xrEnumerateSwapchainFormats", result);
  if (std::find(formats.begin(), formats.end(), GL_SRGB8_ALPHA8) == formats.end())
    return refused("headset: the OpenXR runtime has no pictures of GL_SRGB8_ALPHA8, which are expected");
  return {};
}

OpenXrSwapchain::~OpenXrSwapchain() { release(); }

void OpenXrSwapchain::release() {
  if (handle_ != XR_NULL_HANDLE) xrDestroySwapchain(handle_);
  handle_ = XR_NULL_HANDLE;
  images_.clear();
  uploaded_ = false;
}

Expected<void> OpenXrSwapchain::make(XrSession session, int width, int height) {
  release();
  XrSwapchainCreateInfo info{};
  info.type = XR_TYPE_SWAPCHAIN_CREATE_INFO;
  info.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT;
  info.format = GL_SRGB8_ALPHA8;
  info.sampleCount = 1;
  info.width = static_cast<std::uint32_t>(width);
  info.height = static_cast<std::uint32_t>(height);
  info.faceCount = info.arraySize = info.mipCount = 1;
  if (const XrResult result = xrCreateSwapchain(session, &info, &handle_); XR_FAILED(result)) {
    handle_ = XR_NULL_HANDLE;
    return failed("xrCreateSwapchain", result);
  }
  width_ = width;
  height_ = height;
  std::uint32_t count = 0;
  if (const XrResult result = xrEnumerateSwapchainImages(handle_, 0, &count, nullptr); XR_FAILED(result))
    return failed("xrEnumerateSwapchainImages", result);
  images_.assign(count, {XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR, nullptr, 0});
  if (const XrResult result = xrEnumerateSwapchainImages(
          handle_, count, &count, reinterpret_cast<XrSwapchainImageBaseHeader*>(images_.data()));
      XR_FAILED(result))
    return failed("xrEnumerateSwapchainImages", result);
  return {};
}

Expected<void> OpenXrSwapchain::upload(XrSession session, const Pixels& pixels, unsigned format) {
  if (handle_ == XR_NULL_HANDLE || pixels.width != width_ || pixels.height != height_)
    if (auto made = make(session, pixels.width, pixels.height); !made) return made;
  std::uint32_t image = 0;
  if (const XrResult result = xrAcquireSwapchainImage(handle_, nullptr, &image); XR_FAILED(result))
    return failed("xrAcquireSwapchainImage", result);
  XrSwapchainImageWaitInfo wait{};
  wait.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO;
  wait.timeout = XR_INFINITE_DURATION;  // one that never comes is noticed as a runtime that hangs
  if (const XrResult result = xrWaitSwapchainImage(handle_, &wait); XR_FAILED(result))
    return failed("xrWaitSwapchainImage", result);
  // Bytes go in as they are: GL_FRAMEBUFFER_SRGB concerns drawing alone, and we do not draw.
  glBindTexture(GL_TEXTURE_2D, images_[image].image);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width_, height_, format, GL_UNSIGNED_BYTE, pixels.bytes.data());
  glBindTexture(GL_TEXTURE_2D, 0);
  glFlush();
  if (const XrResult result = xrReleaseSwapchainImage(handle_, nullptr); XR_FAILED(result))
    return failed("xrReleaseSwapchainImage", result);
  uploaded_ = true;
  return {};
}

XrSwapchainSubImage OpenXrSwapchain::part(int x, int width) const {
  XrSwapchainSubImage part{};
  part.swapchain = handle_;
  part.imageRect.offset = {x, 0};
  part.imageRect.extent = {width, height_};
  return part;
}

}  // namespace palpate::headset
