// For tests: a run directory of their own for as long as this lives ($XDG_RUNTIME_DIR, core/run_directory.h), so that
// they meet no other process of this user. The environment is the process's: one at a time, set while no thread reads it.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>

#include "tests/scratch_folder.h"

namespace palpate {

class OwnRunDirectory {
 public:
  OwnRunDirectory() : OwnRunDirectory(std::nullopt) {}
  // At a place that the test chooses, even one that is none.
  explicit OwnRunDirectory(const std::optional<std::string>& place) {
    if (const char* before = std::getenv("XDG_RUNTIME_DIR")) before_ = before;
    setenv("XDG_RUNTIME_DIR", place ? place->c_str() : scratch_.path().c_str(), 1);
  }
  ~OwnRunDirectory() {
    if (before_)
      setenv("XDG_RUNTIME_DIR", before_->c_str(), 1);
    else
      unsetenv("XDG_RUNTIME_DIR");
  }
  OwnRunDirectory(const OwnRunDirectory&) = delete;
  OwnRunDirectory& operator=(const OwnRunDirectory&) = delete;
  const std::filesystem::path& path() const { return scratch_.path(); }

 private:
  ScratchFolder scratch_;
  std::optional<std::string> before_;
};

}  // namespace palpate
