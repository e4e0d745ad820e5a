// For tests: an empty folder of mode 0700, gone with its content at the end.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace palpate {

class ScratchFolder {
 public:
  ScratchFolder() {
    char name[] = "/tmp/palpate-test-XXXXXX";  // short: a socket's path has at most 107 bytes
    if (mkdtemp(name) == nullptr) throw std::runtime_error("no scratch folder");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace palpate
