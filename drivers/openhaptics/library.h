// Finds and loads the maker's libHD.so at run time, and says in words why that did not work.
//
// Where it is looked for: the file that the environment variable PALPATE_LIBHD names, and nothing else where
// it is set; otherwise whatever the loader finds as libHD.so, then the places where the maker's installers
// put it. Once loaded it stays until the process ends: its threads cannot be counted on to be gone before.
// Any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/openhaptics/hd_abi.h"
#include "palpate/core/expected.h"

namespace palpate::drivers::openhaptics {

enum class LibraryProblem : std::uint8_t {
  none,
  not_found,
  unreadable,
  not_a_library,
  thirty_two_bit,
  other_machine,       // built for another processor
  missing_dependency,  // one of the libraries it needs itself
  missing_function,    // too old, or not OpenHaptics' libHD at all
  not_loadable,        // anything else the loader says
};

struct LibraryFacts {
  LibraryProblem problem = LibraryProblem::not_found;
  std::string file;     // looked at; empty: none was found
  std::string detail;   // the missing library, the missing functions, the processor, the loader's words
  std::string version;  // as the library tells it; empty where it does not
  // Empty where there is no problem.
  std::string reason() const, remedy() const;
};

// Looks at the file's head before the loader does, so that a library of another machine is named as such.
// Loads the library. Empty: the default search.
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
