// What people see of a graphics process: the window of who plays, one for those who look on, a headset; any of them,
// or none.
//
// Thread: that of the frame loop, which with a window is the main thread.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "palpate/desktop/desktop_ui.h"
#include "palpate/desktop/headset_view.h"
#include "palpate/desktop/spectator_window.h"
#include "palpate/server/session/graphics_process.h"
#include "palpate/server/session/graphics_side.h"

namespace palpate::server::session {

class GraphicsScreens {
 public:
  // Refused where one that is asked for cannot be had. Options, side and clock must outlive this object; the side's
  // server is told when a headset shows its pictures.
  static Expected<std::unique_ptr<GraphicsScreens>> open(const GraphicsProcessOptions& options,
                                                         GraphicsSide& side,
                                                         const transport::ServerPlace& place,
                                                         const MonotonicClock<GraphicsClock>& clock);
  ~GraphicsScreens();
  GraphicsScreens(const GraphicsScreens&) = delete;
  GraphicsScreens& operator=(const GraphicsScreens&) = delete;

  // A frame has been drawn: for who plays at once, for those who look on when there is time.
  void show(const graphics::FrameRecord& frame);
  void show_to_others(const graphics::FrameRecord& frame);
  // To who plays, for a few seconds, wherever they look.
  void say(const std::string& words);
  // Every millisecond or so; false when the person at the window has quit.
  bool act();
  // The second window, which may be closed while the play goes on.
  void act_for_others();

  desktop::DesktopUi* ui() { return ui_.get(); }  // null: no window
  const desktop::DesktopUi* ui() const { return ui_.get(); }
  // Puts files in place, at the end.
  Expected<void> finish();
  // Adds those of window, monitor and headset.
  void add_figures(Json& result) const;

 private:
  GraphicsScreens(const GraphicsProcessOptions& options, GraphicsSide& side,
                  const MonotonicClock<GraphicsClock>& clock)
      : options_(options), side_(side), clock_(clock) {}
  Expected<void> open_windows(const transport::ServerPlace& place);
  Expected<void> open_headset();
  void act_for_headset();

  const GraphicsProcessOptions& options_;
  GraphicsSide& side_;
  const MonotonicClock<GraphicsClock>& clock_;
  std::unique_ptr<desktop::DesktopUi> ui_;
  std::unique_ptr<desktop::SpectatorWindow> monitor_;
  Json monitored_;  // of the second window, once it has been closed
  std::unique_ptr<desktop::HeadsetView> headset_;
  desktop::HudContent headset_words_;  // where no window has them
};

}  // namespace palpate::server::session
