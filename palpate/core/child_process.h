// A program started beside this one, ended in order: asked with SIGTERM, killed when it does not listen. What it has
// to tell comes as reports over a pipe (child_report.h).
//
// One thread.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/core/child_report.h"
#include "palpate/core/expected.h"

namespace palpate::inline core {

class ChildProcess {
 public:
  // Standard output is thrown away; standard error goes to `log`, for people.
  static Expected<ChildProcess> start(const std::filesystem::path& program,
                                      const std::vector<std::string>& arguments,
                                      const std::filesystem::path& log);
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ~ChildProcess();

  bool running();
  // Waits; the exit code (128 and more: a signal's number on top), or nothing when the patience is over.
  std::optional<int> wait(std::chrono::milliseconds patience);
  void ask_to_stop();

  // Takes what it has told until now.
  const ReportReader& reports();
  // Of one that has ended: its own words, else the signal that ended it, else where its log is.
  std::string why_it_ended();

 private:
  ChildProcess(pid_t pid, ReportReader reports, std::filesystem::path log)
      : pid_(pid), log_(std::move(log)), reports_(std::move(reports)) {}
  pid_t pid_ = -1;
  std::optional<int> status_;
  std::filesystem::path log_;
  ReportReader reports_;
};

}  // namespace palpate::inline core
