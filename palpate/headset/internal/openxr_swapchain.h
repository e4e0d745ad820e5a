// A picture that the runtime and we hold by turns. The thread whose OpenGL context the session has.
#pragma once

#include <vector>

#include "palpate/headset/internal/openxr.h"
#include "palpate/headset/internal/shared_state.h"

namespace palpate::headset {

// Whether the runtime has pictures whose bytes are encoded as sRGB, as ours are: they alone are shown as they are.
Expected<void> look_for_format(XrSession session);

class OpenXrSwapchain {
 public:
  OpenXrSwapchain() = default;
  ~OpenXrSwapchain();
  OpenXrSwapchain(const OpenXrSwapchain&) = delete;
  OpenXrSwapchain& operator=(const OpenXrSwapchain&) = delete;

  // `format`: GL_RGB or GL_RGBA, of the pixels that come in. Made anew where the size is another than before.
  Expected<void> upload(XrSession session, const Pixels& pixels, unsigned format);
  // Before its session goes.
  void release();
  bool holds_picture() const { return uploaded_; }
  // A part of it; pixels, from the left.
  XrSwapchainSubImage part(int x, int width) const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  Expected<void> make(XrSession session, int width, int height);

  XrSwapchain handle_ = XR_NULL_HANDLE;
  std::vector<XrSwapchainImageOpenGLKHR> images_;
  int width_ = 0, height_ = 0;
  bool uploaded_ = false;
};

}  // namespace palpate::headset
