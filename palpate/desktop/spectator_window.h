// A second window for those who look on: what the player sees, or the play from the side.
//
// Drawn after the player's own picture has been shown, in the time that is left (spectator_pace.h). Its keys:
// v turns it from one view to the other, F11 fills the screen, q and Esc close it; the play goes on without
// it. From the side, dragging walks round the play and the wheel comes nearer. Main thread alone, as all windows.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/desktop/spectator_pace.h"
#include "palpate/desktop/window.h"
#include "palpate/render/outside_view.h"
#include "palpate/server/graphics/frame_record.h"
#include "palpate/server/graphics/graphics_figures.h"
#include "palpate/time/clock.h"

namespace palpate::desktop {

// copy: the player's window; of two eyes side by side the left one. outside: outside_view.h.
enum class MonitorView : std::uint8_t { copy, outside };
Expected<MonitorView> parse_monitor_view(std::string_view word);
std::string_view monitor_view_word(MonitorView view);

class SpectatorWindow {
 public:
  // What it shows: a frame, whether the player sees it from the side, and what stands over it.
  struct Sight {
    const server::graphics::FrameRecord& frame;
    bool from_outside = false;
    const HudContent& content;
  };
  using Outside = std::function<const render::OutsidePicture&(const server::graphics::FrameRecord&)>;

  // `player`: the player's window. Refused where no second one can be had.
  static Expected<std::unique_ptr<SpectatorWindow>> open(MonitorView view, const Window& player,
                                                         Outside outside, render::Onlooker& onlooker);

  // The player's picture of this frame has just been shown. `eye_width`: of one eye's picture, px.
  void show(const Sight& sight, int eye_width, const Clock<GraphicsClock>& clock);
  // Every millisecond or so; false when it has been closed.
  bool act(const HudContent& content, Instant<GraphicsClock> now);

  // Pictures drawn, left out, and how long one takes.
  Json figures() const;

 private:
  SpectatorWindow(MonitorView view, Outside outside, render::Onlooker& onlooker)
      : view_(view), outside_(std::move(outside)), onlooker_(onlooker) {}
  void draw(const HudContent& content);
  void walk(const Input& input);

  MonitorView view_;
  Outside outside_;
  render::Onlooker& onlooker_;
  bool walked_ = false;                     // somebody knows how it is done
  std::optional<Eigen::Vector2d> dragged_;  // to here, in the framebuffer
  std::unique_ptr<Window> window_;
  SpectatorPace pace_;
  server::graphics::Quantiles took_;
  std::uint64_t drawn_ = 0, left_out_ = 0;
  std::optional<Instant<GraphicsClock>> looked_;  // shown to, or drawn without a frame
  std::optional<Instant<GraphicsClock>> begun_;   // when it was drawn first
};

}  // namespace palpate::desktop
