// The maker's libHD.so, loaded at run time (drivers/arms/maker_library.h): PALPATE_LIBHD names another file. Any thread.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>

#include "drivers/arms/maker_library.h"
#include "drivers/openhaptics/hd_abi.h"

namespace palpate::drivers::openhaptics {

using arms::LibraryFacts;
using arms::LibraryProblem;

const arms::MakerLibrary& maker_library();
// Empty: the default search.
LibraryFacts inspect_library(const std::filesystem::path& file = {});

class Library {
 public:
  static Expected<std::shared_ptr<Library>> load(const std::filesystem::path& file = {});

  const hd::Functions& hd() const { return hd_; }
  const LibraryFacts& facts() const { return facts_; }
  // Held around every call that does not come from the library's own scheduler: it has one error list and one
  // current device for everybody.
  std::mutex& calls() { return calls_; }
  // Under calls(). The library's scheduler runs while somebody uses it.
  void use_scheduler();
  void release_scheduler();
  // Under calls(). Runs `work` while the scheduler stands still: devices are opened and asked who they are
  // through "the current device", which every cycle of another arm changes.
  template <typename Work>
  void while_scheduler_rests(Work&& work) {
    if (scheduler_users_ > 0) hd_.stop_scheduler();
    work();
    if (scheduler_users_ > 0) hd_.start_scheduler();
  }

 private:
  Library(const hd::Functions& functions, LibraryFacts facts) : hd_(functions), facts_(std::move(facts)) {}
  hd::Functions hd_;
  LibraryFacts facts_;
  std::mutex calls_;
  int scheduler_users_ = 0;
};

}  // namespace palpate::drivers::openhaptics
