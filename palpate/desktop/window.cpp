#include "palpate/desktop/window.h"

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "palpate/device/timecode.h"
#include "palpate/render/gl_objects.h"

namespace palpate::desktop {
namespace {

// The viewport is the box the image fills; row 0 of the image is its top, row 0 of the window its bottom.
const char* const kImageFragment = R"(
uniform sampler2D image;
uniform vec4 box;            // x, y from below, width, height
out vec4 colour;
void main() {
  vec2 at = (gl_FragCoord.xy - box.xy) / box.zw;
  colour = texture(image, vec2(at.x, 1.0 - at.y));
}
)";

constexpr int kBlocksAcross = 48;  // of the timecode, as wide as the window

int windows_open = 0;    // GLFW begins with the first and ends with the last
std::string glfw_words;  // what GLFW said last; its callback has no other place to leave it

void end_glfw() {
  if (windows_open == 0) glfwTerminate();
}

void keep_words(int /*code*/, const char* words) { glfw_words = words; }

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// The screen that holds the place.
GLFWmonitor* screen_at(int x, int y) {
  int count = 0;
  GLFWmonitor** screens = glfwGetMonitors(&count);
  for (int i = 0; i < count; ++i) {
    int left = 0, top = 0;
    glfwGetMonitorPos(screens[i], &left, &top);
    const GLFWvidmode* mode = glfwGetVideoMode(screens[i]);
    if (mode != nullptr && x >= left && x < left + mode->width && y >= top && y < top + mode->height)
      return screens[i];
  }
  return count > 0 ? screens[0] : nullptr;
}

GLFWmonitor* screen_of(GLFWwindow* window) {
  int x = 0, y = 0, width = 0, height = 0;
  glfwGetWindowPos(window, &x, &y);
  glfwGetWindowSize(window, &width, &height);
  return screen_at(x + width / 2, y + height / 2);
}

// Side by side on the one screen there is; where they do not fit, the one that is looked at by others shrinks to what
// is left, but not below a quarter of the screen's width.
void place_side_by_side(GLFWwindow* window, GLFWwindow* first, GLFWmonitor* screen) {
  int x = 0, y = 0, width = 0, height = 0, wide = 0, high = 0, first_x = 0, first_y = 0, first_wide = 0,
      first_high = 0;
  glfwGetMonitorWorkarea(screen, &x, &y, &width, &height);
  glfwGetWindowSize(window, &wide, &high);
  glfwGetWindowSize(first, &first_wide, &first_high);
  glfwGetWindowPos(first, &first_x, &first_y);
  const int left = std::max(width - first_wide, width / 4);
  if (wide > left) {
    high = high * left / wide;
    wide = left;
    glfwSetWindowSize(window, wide, high);
  }
  glfwSetWindowPos(first, x, std::max(first_y, y));
  glfwSetWindowPos(window, x + width - wide, y + std::max(0, height - high));
}

// In the middle of another screen, or beside the first one; that one keeps the keys.
void place_beside(GLFWwindow* window, GLFWwindow* first) {
  int count = 0;
  GLFWmonitor** screens = glfwGetMonitors(&count);
  GLFWmonitor* const taken = screen_of(first);
  GLFWmonitor* free = taken;
  for (int i = 0; i < count; ++i)
    if (screens[i] != taken) free = screens[i];
  if (free == nullptr) return;
  if (free == taken) return place_side_by_side(window, first, free);
  int x = 0, y = 0, width = 0, height = 0, wide = 0, high = 0;
  glfwGetMonitorWorkarea(free, &x, &y, &width, &height);
  glfwGetWindowSize(window, &wide, &high);
  glfwSetWindowPos(window, x + std::max(0, (width - wide) / 2), y + std::max(0, (height - high) / 2));
}

Expected<GLFWwindow*> make_window(const std::string& title, Size size, bool visible) {
  glfw_words.clear();
  glfwSetErrorCallback(keep_words);
  if (glfwInit() != GLFW_TRUE) {
    const std::string display = environment("DISPLAY");
    if (display.empty())
      return refused("window: no display (DISPLAY is not set); start it on a desktop, or without a window");
    return refused("window: the display {} cannot be opened ({}); start it on a desktop, or without a window",
                   display, glfw_words);
  }
  glfwWindowHint(GLFW_CLIENT_API, GLFW_OPENGL_API);
  // The same way to OpenGL as render::Context: two libraries for one thread's context do not go together.
  glfwWindowHint(GLFW_CONTEXT_CREATION_API, GLFW_EGL_CONTEXT_API);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  glfwWindowHint(GLFW_VISIBLE, visible ? GLFW_TRUE : GLFW_FALSE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "palpate");
  glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "palpate");
  GLFWwindow* window = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
  if (window == nullptr) {
    const std::string words = glfw_words;
    end_glfw();
    return refused(
        "window: the display {} offers no OpenGL 3.3 ({}); install a graphics driver (libgl1-mesa-dri "
        "draws without a card), or start without a window",
        environment("DISPLAY"), words);
  }
  return window;
}

}  // namespace

struct Window::Impl {
  GLFWwindow* window = nullptr;
  std::unique_ptr<Hud> hud;
  std::unique_ptr<render::Program> image;
  std::unique_ptr<render::FullScreen> screen;
  render::Texture picture, timecode_panel;
  int eyes = 1;  // that the picture is for
  struct Drawn {
    std::uint64_t version = 0;
    render::Texture texture;
  };
  std::vector<Drawn> panels{Hud::kPlaces};
  std::string renderer;
  Input input;
  struct Place {
    int x = 0, y = 0, width = 0, height = 0;
  };
  std::optional<Place> windowed;  // where to go back to from full screen

  ~Impl() {
    glfwMakeContextCurrent(window);
    panels.clear();
    picture = {};
    timecode_panel = {};
    screen.reset();
    image.reset();
    glfwMakeContextCurrent(nullptr);
    glfwDestroyWindow(window);
    --windows_open;
    end_glfw();
  }

  static Impl& of(GLFWwindow* window) { return *static_cast<Impl*>(glfwGetWindowUserPointer(window)); }

  Size size() const {
    Size s;
    glfwGetFramebufferSize(window, &s.width, &s.height);
    return s;
  }
  Box box() const { return letterbox({picture.width(), picture.height()}, size()); }

  void put(const render::Texture& texture, const Box& at, int height) {
    const int from_below = height - at.y - at.height;
    glViewport(at.x, from_below, at.width, at.height);
    texture.bind(0);
    image->use()
        .set("image", 0)
        .set("box", render::Vector4f(static_cast<float>(at.x), static_cast<float>(from_below),
                                     static_cast<float>(at.width), static_cast<float>(at.height)));
    screen->draw();
  }

  void put_timecode(Duration now, Size window_size) {
    const int block = std::max(4, window_size.width / kBlocksAcross);
    const int wide = static_cast<int>(device::kPanelWide * block),
              high = static_cast<int>(device::kPanelHigh * block);
    std::vector<std::uint8_t> rgb(3 * static_cast<std::size_t>(wide) * static_cast<std::size_t>(high));
    device::draw_panel(rgb, wide, high, 0, 0, block, now);
    if (timecode_panel.width() != wide || timecode_panel.height() != high)
      timecode_panel = render::Texture(wide, high, render::Format::rgb8, render::Filter::nearest);
    timecode_panel.upload(rgb.data());
    put(timecode_panel, {(window_size.width - wide) / 2, 0, wide, high}, window_size.height);
  }

  void on_key(int key, int action, int mods) {
    if (action == GLFW_RELEASE) return;
    if (key == GLFW_KEY_UP) return input.keys.push_back(Key::farther);
    if (key == GLFW_KEY_DOWN) return input.keys.push_back(Key::nearer);
    if (action == GLFW_REPEAT) return;
    if ((key == GLFW_KEY_ENTER && (mods & GLFW_MOD_ALT) == 0) || key == GLFW_KEY_KP_ENTER)
      input.typed += '\n';
    if (key == GLFW_KEY_ESCAPE) input.keys.push_back(Key::escape);
    if (key == GLFW_KEY_F11 || (key == GLFW_KEY_ENTER && (mods & GLFW_MOD_ALT) != 0))
      input.keys.push_back(Key::full_screen);
    if (key == GLFW_KEY_F1) input.keys.push_back(Key::help);
  }

  // Letters as the keyboard's own layout has them.
  void on_letter(unsigned letter) {
    if (letter >= 32 && letter < 127)
      input.typed += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    switch (letter) {
      case ' ':
        return input.keys.push_back(Key::serve);
      case 'p':
      case 'P':
        return input.keys.push_back(Key::pause);
      case 'r':
      case 'R':
        return input.keys.push_back(Key::reset);
      case 'a':
      case 'A':
        return input.keys.push_back(Key::program_plays);
      case 's':
      case 'S':
        return input.keys.push_back(Key::strokes);
      case 'l':
      case 'L':
        return input.keys.push_back(Key::look);
      case 'k':
      case 'K':
        return input.keys.push_back(Key::head);
      case 'v':
      case 'V':
        return input.keys.push_back(Key::view);
      case 'h':
      case 'H':
      case '?':
        return input.keys.push_back(Key::help);
      case 'q':
      case 'Q':
        return input.keys.push_back(Key::quit);
      default:
        return;
    }
  }

  void on_pointer(double x, double y) {
    int width = 0, height = 0;
    glfwGetWindowSize(window, &width, &height);
    const Size pixels = size();
    if (width <= 0 || height <= 0) return;
    const Eigen::Vector2d at(x * pixels.width / width, y * pixels.height / height);
    if (input.pointer) input.moved += (at - *input.pointer).norm();
    input.pointer = at;
  }
};

Expected<std::unique_ptr<Window>> Window::open(const std::string& title, Size size, const Window* beside) {
  auto lettering = Lettering::open();
  if (!lettering) return tl::unexpected(lettering.error());
  auto made = make_window(title, size, beside == nullptr);
  if (!made) return tl::unexpected(made.error());
  auto impl = std::make_unique<Impl>();
  impl->window = *made;
  ++windows_open;
  impl->hud = std::make_unique<Hud>(std::move(*lettering));
  glfwMakeContextCurrent(impl->window);
  glfwSwapInterval(0);
  if (const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER))) impl->renderer = name;
  impl->image = std::make_unique<render::Program>("window/image", render::kFullScreen, kImageFragment);
  impl->screen = std::make_unique<render::FullScreen>();
  GLFWwindow* window = impl->window;
  glfwSetWindowUserPointer(window, impl.get());
  glfwSetWindowSizeLimits(window, 320, 240, GLFW_DONT_CARE, GLFW_DONT_CARE);
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int mods) {
    Impl::of(w).on_key(key, action, mods);
  });
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned letter) { Impl::of(w).on_letter(letter); });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double y) { Impl::of(w).input.wheel += y; });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) { Impl::of(w).on_pointer(x, y); });
  if (beside != nullptr) {
    place_beside(window, beside->impl_->window);
    glfwSetWindowAttrib(window, GLFW_FOCUS_ON_SHOW, GLFW_FALSE);
    glfwShowWindow(window);
    glfwFocusWindow(beside->impl_->window);
    return std::unique_ptr<Window>(new Window(std::move(impl)));
  }
  if (GLFWcursor* cross = glfwCreateStandardCursor(GLFW_CROSSHAIR_CURSOR)) glfwSetCursor(window, cross);
  return std::unique_ptr<Window>(new Window(std::move(impl)));
}

Expected<void> Window::possible() {
  auto made = make_window("palpate", {64, 48}, false);
  if (!made) return tl::unexpected(made.error());
  glfwDestroyWindow(*made);
  end_glfw();
  return {};
}

Window::Window(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Window::~Window() = default;

Input Window::poll() {
  // Events of every window come at once: what another one's poll has brought since is told, too.
  glfwPollEvents();
  Input input = impl_->input;
  impl_->input.keys.clear();
  impl_->input.typed.clear();
  impl_->input.wheel = impl_->input.moved = 0.0;
  input.left = glfwGetMouseButton(impl_->window, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
  input.right = glfwGetMouseButton(impl_->window, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS;
  input.closed = glfwWindowShouldClose(impl_->window) == GLFW_TRUE;
  if (input.closed) input.keys.push_back(Key::quit);
  return input;
}

void Window::take_picture(std::span<const std::uint8_t> rgb, Size picture, int eyes) {
  glfwMakeContextCurrent(impl_->window);
  impl_->eyes = std::max(1, eyes);
  if (impl_->picture.width() != picture.width || impl_->picture.height() != picture.height)
    impl_->picture =
        render::Texture(picture.width, picture.height, render::Format::rgb8, render::Filter::linear);
  impl_->picture.upload(rgb.data());
}

void Window::draw(const HudContent& content, std::optional<Duration> timecode) {
  const Size size = impl_->size();
  if (size.width <= 0 || size.height <= 0) return;  // made an icon of
  glfwMakeContextCurrent(impl_->window);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  glViewport(0, 0, size.width, size.height);
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  if (impl_->picture) impl_->put(impl_->picture, impl_->box(), size.height);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  const int part = size.width / impl_->eyes;  // of the window, for each eye
  const auto& panels = impl_->hud->lay_out(content, {part, size.height});
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const Canvas& canvas = panels[i].canvas;
    if (canvas.width <= 0 || canvas.height <= 0) continue;
    auto& drawn = impl_->panels[i];
    if (drawn.version != panels[i].version) {
      drawn.version = panels[i].version;
      if (drawn.texture.width() != canvas.width || drawn.texture.height() != canvas.height)
        drawn.texture =
            render::Texture(canvas.width, canvas.height, render::Format::rgba8, render::Filter::nearest);
      drawn.texture.upload(canvas.rgba.data());
    }
    for (int eye = 0; eye < impl_->eyes; ++eye)
      impl_->put(drawn.texture, {panels[i].x + eye * part, panels[i].y, canvas.width, canvas.height},
                 size.height);
  }
  glDisable(GL_BLEND);
  if (timecode) impl_->put_timecode(*timecode, size);  // over all else: a camera has to read it
  glfwSwapBuffers(impl_->window);
}

void Window::toggle_full_screen() {
  GLFWwindow* window = impl_->window;
  if (const auto back = impl_->windowed) {
    glfwSetWindowMonitor(window, nullptr, back->x, back->y, back->width, back->height, GLFW_DONT_CARE);
    impl_->windowed.reset();
    return;
  }
  Impl::Place here;
  glfwGetWindowPos(window, &here.x, &here.y);
  glfwGetWindowSize(window, &here.width, &here.height);
  GLFWmonitor* chosen = screen_of(window);
  const GLFWvidmode* mode = chosen == nullptr ? nullptr : glfwGetVideoMode(chosen);
  if (mode == nullptr) return;
  impl_->windowed = here;
  glfwSetWindowMonitor(window, chosen, 0, 0, mode->width, mode->height, mode->refreshRate);
}

Size Window::framebuffer() const { return impl_->size(); }
const std::string& Window::renderer() const { return impl_->renderer; }

}  // namespace palpate::desktop
