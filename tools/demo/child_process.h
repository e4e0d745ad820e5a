// A program started beside this one, ended in order: asked with SIGTERM, killed when it does not listen.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::tools::demo {

class ChildProcess {
 public:
  // Standard output is thrown away; standard error goes to `log`.
  static Expected<ChildProcess> start(const std::filesystem::path& program,
                                      const std::vector<std::string>& arguments,
                                      const std::filesystem::path& log);
  ChildProcess(ChildProcess&& other) noexcept : pid_(std::exchange(other.pid_, -1)), status_(other.status_) {}
  ChildProcess& operator=(ChildProcess&&) = delete;
  ~ChildProcess();

  bool running();
  // Waits; the exit code, or nothing when the patience is over.
  std::optional<int> wait(std::chrono::milliseconds patience);
  void ask_to_stop();

 private:
  explicit ChildProcess(pid_t pid) : pid_(pid) {}
  pid_t pid_ = -1;
  std::optional<int> status_;
};

// The last line a process wrote to its log: its error, if it had one.
std::string last_words(const std::filesystem::path& log);

}  // namespace palpate::tools::demo
