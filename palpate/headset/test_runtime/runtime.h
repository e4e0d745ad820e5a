// The test runtime's state; entry_points.cpp is what OpenXR's loader sees of it.
#pragma once

#include <EGL/egl.h>
#include <GL/gl.h>
#include <time.h>

#include <array>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#define XR_USE_PLATFORM_EGL
#define XR_USE_GRAPHICS_API_OPENGL
#define XR_USE_TIMESPEC
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "compositor.h"
#include "test_runtime_for_tests.h"

namespace palpate::headset {

struct Swapchain {
  XrSwapchainCreateInfo info{};
  std::array<GLuint, 3> textures{};
  std::deque<std::uint32_t> acquired;
  std::uint32_t next = 0;
  bool waited = false;
  std::shared_ptr<const LayerImage> newest;
};

// OpenGL as the application's own context has it.
struct OpenGl {
  void (*gen_textures)(GLsizei, GLuint*) = nullptr;
  void (*delete_textures)(GLsizei, const GLuint*) = nullptr;
  void (*bind_texture)(GLenum, GLuint) = nullptr;
  void (*image)(GLenum, GLint, GLint, GLsizei, GLsizei, GLint, GLenum, GLenum, const void*) = nullptr;
  void (*read_image)(GLenum, GLint, GLenum, GLenum, void*) = nullptr;
  void (*get)(GLenum, GLint*) = nullptr;
  void (*pixel_store)(GLenum, GLint) = nullptr;
  bool load(PFNEGLGETPROCADDRESSPROC find);
};

class Runtime : public TestRuntime {
 public:
  static Runtime& the();

  void reset(const TestDisplay& display) override;
  void move_head(std::function<HeadPlace(std::int64_t)> place) override;
  void lay_local_anew() override;
  std::int64_t now_ns() const override;
  std::int64_t period_ns() const override;
  bool refresh(double patience_s) override;
  void run_by_itself() override;
  void wear(bool worn) override;
  void hang(bool hung) override;
  void end_session_by_force() override;
  bool instance_open() const override;
  void vanish() override;
  void return_again() override;
  void refuse(Refusal refusal) override;
  EyePicture seen(int eye, std::int64_t monotonic_ns) const override;
  TestCounts counts() const override;

  // What the entry points do. Each takes the mutex; gone() is asked before.
  bool gone() const;
  Refusal refusal() const;
  XrResult make_instance(XrInstance* instance);
  void end_instance();
  XrResult make_session(const XrSessionCreateInfo& info, XrSession* session);
  void end_session_object();
  XrResult next_event(XrEventDataBuffer& event);
  XrResult make_space(XrReferenceSpaceType type, XrSpace* space);
  XrResult locate(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation& location);
  XrResult make_swapchain(const XrSwapchainCreateInfo& info, XrSwapchain* swapchain);
  XrResult end_swapchain(XrSwapchain swapchain);
  XrResult images(XrSwapchain swapchain, std::uint32_t capacity, std::uint32_t* count,
                  XrSwapchainImageBaseHeader* images);
  XrResult acquire(XrSwapchain swapchain, std::uint32_t* index);
  XrResult wait_image(XrSwapchain swapchain);
  XrResult release(XrSwapchain swapchain);
  XrResult begin_session();
  XrResult end_session();
  XrResult wait_frame(XrFrameState& state);
  XrResult begin_frame();
  XrResult end_frame(const XrFrameEndInfo& info);
  void requirements_asked() { requirements_ = true; }

 private:
  std::int64_t now_locked() const;
  void obey_file();
  void put_session(XrSessionState state);
  Placed head_at(std::int64_t monotonic_ns) const;   // in the room
  Placed local_at(std::int64_t monotonic_ns) const;  // the same
  XrResult layer_of(const XrCompositionLayerBaseHeader& header, std::int64_t display_ns, Layer& layer) const;
  XrResult part_of(const XrSwapchainSubImage& sub, LayerPart& part) const;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  TestDisplay display_;
  std::function<HeadPlace(std::int64_t)> motion_;
  // LOCAL in the room; it was laid there at that time and holds until the next.
  std::vector<std::pair<std::int64_t, Placed>> locals_;
  bool virtual_time_ = true, hung_ = false, gone_ = false, worn_ = true, requirements_ = false;
  Refusal refusal_ = Refusal::none;
  std::int64_t virtual_ns_ = 0;
  std::uint64_t frame_asked_ = 0, frame_waited_ = 0, frame_ended_ = 0;
  std::int64_t last_real_ns_ = 0;
  std::string file_said_;
  bool instance_ = false, session_ = false, running_ = false, begun_ = false;
  bool wait_done_ = false;  // a frame has been waited for, and not begun
  OpenGl gl_;
  std::deque<XrEventDataBuffer> events_;
  std::map<std::uint64_t, XrReferenceSpaceType> spaces_;
  std::map<std::uint64_t, Swapchain> swapchains_;
  std::uint64_t handles_ = 0;
  std::vector<Layer> layers_;  // of the newest frame, in the room
  TestCounts counts_;
};

}  // namespace palpate::headset
