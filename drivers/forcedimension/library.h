// The maker's libdhd.so or libdrd.so, loaded at run time (drivers/arms/maker_library.h): PALPATE_LIBDHD names another file.
// Any thread.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <set>

#include "drivers/arms/maker_library.h"
#include "drivers/forcedimension/dhd_abi.h"

namespace palpate::drivers::forcedimension {

const arms::MakerLibrary& maker_library();
// Empty: the default search.
arms::LibraryFacts inspect_library(const std::filesystem::path& file = {});

class Library {
 public:
  static Expected<std::shared_ptr<Library>> load(const std::filesystem::path& file = {});

  const dhd::Functions& dhd() const { return dhd_; }
  const arms::LibraryFacts& facts() const { return facts_; }

  // Held while devices are opened and closed. Ids that this process has open: the library opens none of them twice, and
  // gives the same id again.
  std::mutex& opening() { return opening_; }
  std::set<int>& open_ids() { return open_ids_; }

 private:
  Library(const dhd::Functions& functions, arms::LibraryFacts facts)
      : dhd_(functions), facts_(std::move(facts)) {}
  dhd::Functions dhd_;
  arms::LibraryFacts facts_;
  std::mutex opening_;
  std::set<int> open_ids_;
};

}  // namespace palpate::drivers::forcedimension
