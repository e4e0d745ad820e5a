// The window of a guided session: runs the session in a thread of its own and draws meanwhile.
//
// Windows belong to the main thread, and drawing must not hold up the session, which reads an arm a thousand times a
// second. Both meet in a SessionExchange. Keys go to the session as letters, Enter as '\n'; F11 fills the screen;
// closing the window asks the program to stop, as Ctrl-C does. Main thread alone. Refused where no window can be had.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/desktop/session_page.h"
#include "palpate/desktop/session_view.h"
#include "palpate/desktop/sound_out.h"
#include "palpate/desktop/window.h"

namespace palpate::desktop {

class SessionWindow {
 public:
  static Expected<std::unique_ptr<SessionWindow>> open(const std::string& title);

  // Until `session` has returned; what it returned, or threw.
  Expected<void> run(const std::function<Expected<void>(SessionExchange&)>& session);

 private:
  SessionWindow(std::unique_ptr<Window> window, std::unique_ptr<Lettering> lettering,
                std::unique_ptr<SoundOut> sound);
  void act(SessionExchange& exchange);
  void draw(const SessionView& view);
  void sound(const SessionView& view);

  std::unique_ptr<Window> window_;
  std::unique_ptr<SoundOut> sound_;  // null: silent
  SessionPage page_;
  std::vector<std::uint8_t> rgb_;
  std::uint64_t drawn_ = 0;
  Size drawn_size_;
  std::optional<double> heard_s_;
  bool heard_outcome_ = false, closed_ = false;
};

}  // namespace palpate::desktop
