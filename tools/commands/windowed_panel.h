// A session's panel in a window beside the terminal: what the terminal shows the window gets, too, and more to draw
// with; keys of either answer.
//
// The session's thread; the window's takes part through the exchange alone.
#pragma once

#include <span>

#include "palpate/calibration/session/picture_marker.h"
#include "palpate/calibration/session/session_panel.h"
#include "palpate/desktop/session_view.h"
#include "palpate/device/devices.h"
#include "tools/commands/terminal_panel.h"

namespace palpate::tools::commands {

class WindowedPanel : public calibration::session::SessionPanel {
 public:
  // Both must outlive this object.
  WindowedPanel(TerminalPanel& terminal, desktop::SessionExchange& exchange);

  void show(const device::Request& request, const std::string& text) override;
  void tell(const std::string& line) override;
  void observe(const calibration::session::PersonView& view) override;
  void released() override { terminal_.released(); }
  void taken() override;
  std::optional<calibration::session::PanelKey> key() override { return terminal_.key(); }
  void begin_step(std::size_t step, std::size_t steps, const std::string& name) override;
  void keep_step(const std::string& name, const std::string& words) override {
    terminal_.keep_step(name, words);
  }
  calibration::session::Review review(const calibration::session::StepOutcome& outcome) override;
  void guided(const calibration::session::GuidanceState& state, int of) override;
  void show_rig(const rig::Rig& rig) override;

  // What the tracker has told until `now_s`, host time; in each tick.
  void watch(double now_s, std::span<const device::TrackerSample> tracked) { marker_.watch(now_s, tracked); }
  // A picture of the left or the right camera, looked at at `now_s`.
  void show_picture(const device::CameraImage& image, bool right, double now_s);

 private:
  TerminalPanel& terminal_;
  desktop::SessionExchange& exchange_;
  calibration::session::PictureMarker marker_;
  double camera_after_tracker_s_ = 0.0;
};

}  // namespace palpate::tools::commands
