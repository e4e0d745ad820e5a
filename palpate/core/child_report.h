// What a program tells the one that started it: that it is ready, what it refused, what it measured. One line of
// JSON each, over a pipe of their own, so that nobody searches a log for words.
//
//   {"event": "ready"}
//   {"event": "error", "message": "..."}
//   {"event": "result", "figures": {...}}
//
// The child finds its end of the pipe by the environment variable PALPATE_REPORT_FD; where nobody set it, telling
// does nothing. A parent that does not read, or is gone, holds nobody up for long: a line is then left out.
// Thread: any for tell_parent(), one for a ReportReader; end_with_parent() once, before a thread of the child takes
// real-time rights.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/core/file_descriptor.h"
#include "palpate/core/json.h"

namespace palpate::inline core {

inline constexpr const char* kReportVariable = "PALPATE_REPORT_FD";

// Lines beyond this are refused on both sides, bytes. A run's figures take some ten thousand.
inline constexpr std::size_t kLongestReport = 4 * 1024 * 1024;

// The child's side. The first call takes the descriptor over, so that no process started from here inherits it.
void tell_parent(const Json& report);
void tell_parent_ready();
void tell_parent_error(const std::string& message);
void tell_parent_result(const Json& figures);

// From now on SIGTERM comes when the parent's ReportReader is gone, however the parent ended: no server with an arm
// goes on for nobody. Without a parent that listens: nothing.
void end_with_parent();

// The parent's side: what has come so far.
class ReportReader {
 public:
  ReportReader() = default;
  explicit ReportReader(FileDescriptor descriptor) : descriptor_(std::move(descriptor)) {}

  // Takes what has come, without waiting. A line that is no report is left out.
  void read();
  bool ready() const { return ready_; }
  const std::optional<std::string>& error() const { return error_; }  // the last one
  const std::optional<Json>& result() const { return result_; }

 private:
  void take(std::string_view line);
  FileDescriptor descriptor_;
  std::string begun_;  // of the line that is not complete yet
  bool ready_ = false;
  std::optional<std::string> error_;
  std::optional<Json> result_;
};

}  // namespace palpate::inline core
