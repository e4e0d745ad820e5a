// A session's panel in a window beside the terminal: what the terminal shows the window gets, too, and more to draw
// with; keys of either answer.
//
// The session's thread; the window's takes part through the exchange alone.
#pragma once

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
  void taken() override;
  std::optional<calibration::session::PanelKey> key() override { return terminal_.key(); }
  void begin_step(std::size_t step, std::size_t steps, const std::string& name) override;
  calibration::session::Review review(const calibration::session::StepOutcome& outcome) override;
  void guided(const calibration::session::GuidanceState& state, int of) override;
  void show_rig(const rig::Rig& rig) override;

  // A picture of the left or the right camera.
  void show_picture(const device::CameraImage& image, bool right);

 private:
  TerminalPanel& terminal_;
  desktop::SessionExchange& exchange_;
};

}  // namespace palpate::tools::commands
