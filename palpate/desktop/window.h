// A window on the desktop (GLFW) that shows pictures with panels over them, and tells what mouse and keys do.
//
// The picture keeps its proportions, whatever the window's. Drawing is done in an OpenGL context of the
// window's own; other contexts of the thread (render::Context) live beside it and are made current again by
// whoever uses them. It does not wait for the screen's refresh: whoever draws pictures on the camera's beat
// must not be held up by another one. Refused, with the reason, where there is no display or it offers no
// OpenGL 3.3. Thread: the process' main thread alone (GLFW's rule). There
// may be several: each has its own input.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/desktop/hud.h"
#include "palpate/desktop/letterbox.h"
#include "palpate/time/instant.h"

namespace palpate::desktop {

enum class Key {
  serve,
  pause,
  reset,
  program_plays,
  strokes,
  view,
  look,
  head,
  full_screen,
  help,
  escape,  // closes what stands over the picture, or quits
  quit,
  farther,
  nearer
};

// Since the last poll.
struct Input {
  std::optional<Eigen::Vector2d> pointer;  // in the framebuffer; none: it has never been in the window
  double moved = 0.0;                      // px the pointer went
  double wheel = 0.0;                      // notches, away from the person positive
  bool left = false, right = false;        // buttons held now
  std::vector<Key> keys;                   // pressed, in their order; closing the window is `quit`
  std::string typed;    // the same as letters, as the keyboard has them, small ones; Enter is '\n'
  bool closed = false;  // somebody has closed the window
};

// Where somebody sees the pictures and moves the mouse: a window; in tests, what they are handed.
class Screen {
 public:
  virtual ~Screen() = default;
  virtual Input poll() = 0;
  // Packed RGB, row 0 on top; shown from the next draw() on. `eyes`: so many pictures side by side, and what
  // stands over the picture stands over each.
  virtual void take_picture(std::span<const std::uint8_t> rgb, Size picture, int eyes) = 0;
  // With the timecode of this moment in a panel over the picture's upper edge, where one is given.
  virtual void draw(const HudContent& content, std::optional<Duration> timecode) = 0;
  virtual void toggle_full_screen() = 0;
  virtual Size framebuffer() const = 0;
};

class Window : public Screen {
 public:
  // `beside`: that of the person who plays. This one comes up without taking keys away from it, on another
  // screen where there is one.
  static Expected<std::unique_ptr<Window>> open(const std::string& title, Size size,
                                                const Window* beside = nullptr);
  // Whether one could be opened here; opens one unseen and closes it again.
  static Expected<void> possible();
  ~Window() override;
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  Input poll() override;
  void take_picture(std::span<const std::uint8_t> rgb, Size picture, int eyes = 1) override;
  void draw(const HudContent& content, std::optional<Duration> timecode = {}) override;
  void toggle_full_screen() override;

  Size framebuffer() const override;
  const std::string& renderer() const;

 private:
  struct Impl;
  explicit Window(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::desktop
