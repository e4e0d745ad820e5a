// The log: what a person should know while a program runs, a line each, with its level, its time and the part that it
// comes from.
//
// A library prints nothing: lines go where the program sends them, and before that nowhere. Every line is plain when it
// reaches a sink: control characters of texts that it quotes are '?' (palpate/core/text.h), so none steers a terminal.
// Any thread, except in the 1 kHz loops: a line allocates, locks and may wait for a disk. In those a fault is a state,
// and an ordinary thread that watches them logs it. Nothing here throws.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::inline core {

enum class LogLevel : std::uint8_t {
  debug,    // for whoever looks for a fault: in a log file only
  info,     // something began, ended or changed
  warning,  // it goes on, but not as it should
  error,    // what was asked for ends
};
std::string_view name_of(LogLevel level);

struct LogLine {
  LogLevel level = LogLevel::info;
  std::chrono::system_clock::time_point time;
  std::string text;  // "graphics: publishes poses ..."; plain
};
// Called by one thread at a time, in the order of the lines; does not log itself.
using LogSink = std::function<void(const LogLine&)>;

// Of one part of a program; a constant.
class Log {
 public:
  // `part`: "physics", a literal; empty: of the program as a whole.
  constexpr explicit Log(const char* part = "") : part_(part) {}

  template <typename... Args>
  void debug(fmt::format_string<Args...> format, Args&&... args) const {
    write(LogLevel::debug, fmt::format(format, std::forward<Args>(args)...));
  }
  template <typename... Args>
  void info(fmt::format_string<Args...> format, Args&&... args) const {
    write(LogLevel::info, fmt::format(format, std::forward<Args>(args)...));
  }
  // A short line does not show its level: where a person must not take it for news, its words begin "warning: ".
  template <typename... Args>
  void warning(fmt::format_string<Args...> format, Args&&... args) const {
    write(LogLevel::warning, fmt::format(format, std::forward<Args>(args)...));
  }
  template <typename... Args>
  void error(fmt::format_string<Args...> format, Args&&... args) const {
    write(LogLevel::error, fmt::format(format, std::forward<Args>(args)...));
  }
  // `text` as it is.
  void write(LogLevel level, std::string_view text) const noexcept;

 private:
  const char* part_;
};

// Where lines go, each beside the others that were named before.

// Standard error, from `info` on, without level and time: "palpate: physics: answers ...". Once, however often it is
// asked for.
void log_to_standard_error();
// A file that the lines of all levels are added to, each with date, time of day, zone and level; several processes may
// share it. Refused where it cannot be opened. When it can no longer be written, the other sinks are told once.
Expected<void> log_to_file(const std::filesystem::path& path);
void log_to(LogSink sink);
// No sink any more.
void log_to_nobody();

// For a test, or a window of its own: keeps the lines of its life in place of all sinks, which come back at its end.
class LogCapture {
 public:
  LogCapture();
  ~LogCapture();
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;

  std::vector<LogLine> lines() const;
  std::string text() const;  // of all lines, each with its end

 private:
  std::shared_ptr<void> before_;  // the sinks it stands in for
  mutable std::mutex mutex_;
  std::vector<LogLine> lines_;
};

}  // namespace palpate::inline core
