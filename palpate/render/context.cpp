#include "palpate/render/context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace palpate::render {
namespace {

thread_local std::weak_ptr<Context> this_threads_context;

bool has_word(const char* words, const char* word) {
  const std::size_t length = std::strlen(word);
  for (const char* at = words; at != nullptr && (at = std::strstr(at, word)) != nullptr; at += length) {
    if ((at == words || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return true;
  }
  return false;
}

struct Display {
  EGLDisplay handle = EGL_NO_DISPLAY;
  const char* platform = "";
};

std::vector<Display> displays() {
  std::vector<Display> found;
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (client != nullptr && has_word(client, "EGL_EXT_platform_base")) {
    if (has_word(client, "EGL_EXT_platform_device") && has_word(client, "EGL_EXT_device_base")) {
      std::array<EGLDeviceEXT, 16> devices{};
      EGLint count = 0;
      if (eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count)) {
        for (int i = 0; i < count; ++i) {
          // Mesa's own software device comes last in its list; the surfaceless platform is the same renderer.
          const char* of_device = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
          if (of_device != nullptr && has_word(of_device, "EGL_MESA_device_software")) continue;
          found.push_back({eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr), "device"});
        }
      }
    }
    if (has_word(client, "EGL_MESA_platform_surfaceless")) {
      found.push_back({eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr),
                       "surfaceless"});
    }
  }
  found.push_back({eglGetDisplay(EGL_DEFAULT_DISPLAY), "default"});
  return found;
}

struct MadeContext {
  EGLContext handle = EGL_NO_CONTEXT;
  EGLConfig config = nullptr;
};

MadeContext context_on(EGLDisplay display) {
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) return {};
  const char* extensions = eglQueryString(display, EGL_EXTENSIONS);
  if (!has_word(extensions, "EGL_KHR_surfaceless_context") || !eglBindAPI(EGL_OPENGL_API)) return {};
  const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  if (!eglChooseConfig(display, wanted, &config, 1, &configs)) return {};
  if (configs == 0) {
    if (!has_word(extensions, "EGL_KHR_no_config_context")) return {};
    config = EGL_NO_CONFIG_KHR;
  }
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                            3,
                            EGL_CONTEXT_MINOR_VERSION,
                            3,
                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                            EGL_NONE};
  return {eglCreateContext(display, config, EGL_NO_CONTEXT, version), config};
}

}  // namespace

Expected<std::shared_ptr<Context>> Context::of_this_thread() {
  if (auto context = this_threads_context.lock()) {
    context->make_current();
    return context;
  }
  for (const Display& display : displays()) {
    const auto [handle, config] = context_on(display.handle);
    if (handle == EGL_NO_CONTEXT) continue;
    if (!eglMakeCurrent(display.handle, EGL_NO_SURFACE, EGL_NO_SURFACE, handle)) {
      eglDestroyContext(display.handle, handle);
      continue;
    }
    std::shared_ptr<Context> context(new Context());
    context->display_ = display.handle;
    context->config_ = config;
    context->context_ = handle;
    context->renderer_ = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    context->version_ = reinterpret_cast<const char*>(glGetString(GL_VERSION));
    context->platform_ = display.platform;
    this_threads_context = context;
    return context;
  }
  return refused(
      "drawing: no EGL display (devices, surfaceless Mesa, default) offers an OpenGL 3.3 core context; "
      "install a graphics driver or Mesa's software renderer (libegl-mesa0, libgl1-mesa-dri)");
}

std::shared_ptr<Context> Context::required() {
  auto context = of_this_thread();
  if (!context) throw std::runtime_error(context.error().message);
  return *context;
}

Context::~Context() {
  if (eglGetCurrentContext() == context_) {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  eglDestroyContext(display_, context_);
}

bool Context::is_software() const {
  return renderer_.find("llvmpipe") != std::string::npos || renderer_.find("softpipe") != std::string::npos;
}

bool Context::make_current() const {
  if (eglGetCurrentContext() == context_) return true;
  return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
}

}  // namespace palpate::render
