// An OpenGL 3.3 core context without a window, for pictures that go to memory.
//
// Displays are tried in this order: the EGL devices (a graphics card's own driver), Mesa without a surface
// (works everywhere, also without a card, in software), the default display. Everything is drawn into
// framebuffer objects. Thread: a context belongs to the thread that first asked for it; what is built on it
// is used and destroyed there.
#pragma once

#include <memory>
#include <string>

#include "palpate/core/expected.h"

namespace palpate::render {

class Context {
 public:
  // This thread's context, made at the first call and kept as long as anyone holds it. Refused where no
  // display offers OpenGL 3.3.
  static Expected<std::shared_ptr<Context>> of_this_thread();
  // The same for constructors: throws std::runtime_error with the reason.
  static std::shared_ptr<Context> required();

  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  // Cheap where it is current already. False on a thread that does not own the context.
  bool make_current() const;
  // Whether the processor draws: then it does some things quicker by itself.
  bool is_software() const;
  const std::string& renderer() const { return renderer_; }  // as the driver names itself
  const std::string& version() const { return version_; }    // OpenGL and driver
  const std::string& platform() const { return platform_; }  // "device", "surfaceless" or "default"

  // For a library that shares this context's textures: EGLDisplay, EGLConfig and EGLContext. A null config is
  // EGL_NO_CONFIG_KHR: the context was made without one.
  struct Native {
    void *display = nullptr, *config = nullptr, *context = nullptr;
  };
  Native native() const { return {display_, config_, context_}; }

 private:
  Context() = default;
  void* display_ = nullptr;
  void* config_ = nullptr;
  void* context_ = nullptr;
  std::string renderer_, version_, platform_;
};

}  // namespace palpate::render
