// A terminal as the panel of a calibration session: what to do in lines, how it goes in the last line (where it is a file or a pipe: in a
// line each five seconds), keys without
// Enter where it is a terminal; a pipe on standard input serves for keys, too.
//
// Keys: Enter or space goes on, n: no more, s: another pose, r: repeat, u: undo, q: stop. The end of standard input
// stops, unless there are further keys. One object at a time, one thread. The terminal is as it was when the object
// goes.
#pragma once

#include <termios.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "palpate/calibration/session/instruction_file.h"
#include "palpate/calibration/session/session_panel.h"

namespace palpate::tools::commands {

class TerminalPanel : public calibration::session::SessionPanel {
 public:
  // `instructions` gets what is shown; never null.
  TerminalPanel(std::shared_ptr<calibration::session::InstructionFile> instructions,
                const std::atomic<bool>& stop);
  ~TerminalPanel() override;

  void show(const device::Request& request, const std::string& text) override;
  void tell(const std::string& line) override;
  void observe(const calibration::session::PersonView& view) override { instructions_->write_seen(view); }
  void released() override;
  void taken() override;
  std::optional<calibration::session::PanelKey> key() override;

  void begin_step(std::size_t step, std::size_t steps, const std::string& name) override;
  void keep_step(const std::string& name, const std::string& words) override;
  calibration::session::Review review(const calibration::session::StepOutcome& outcome) override;
  void guided(const calibration::session::GuidanceState& state, int of) override;

  // Keys that are pressed elsewhere, as these are here; asked often, never waits.
  using MoreKeys = std::function<std::optional<char>()>;
  void set_more_keys(MoreKeys keys) { more_keys_ = std::move(keys); }

 private:
  void line(const std::string& text);
  void log_told(const std::string& text);
  // Waits `ms` at most.
  std::optional<char> press(int ms);

  std::shared_ptr<calibration::session::InstructionFile> instructions_;
  const std::atomic<bool>& stop_;
  std::optional<termios> before_;
  MoreKeys more_keys_;
  bool draws_ = false, ended_ = false, told_ = false;
  std::string last_told_;  // stands there while told_
  std::chrono::steady_clock::time_point next_told_{};
};

}  // namespace palpate::tools::commands
