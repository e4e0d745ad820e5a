// Finds and loads a maker's shared library at run time, and says in words why that did not work.
//
// Where it is looked for: the file that the library's environment variable names, and nothing else where it is set;
// otherwise whatever the loader finds by its names, then the places where the maker's installers put it. Once loaded it
// stays until the process ends: its threads cannot be counted on to be gone before. Any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::drivers::arms {

// Which library it is, and what a person calls it.
struct MakerLibrary {
  std::string file;      // "libHD.so"
  std::string product;   // "OpenHaptics"
  std::string driver;    // "arm openhaptics", which begins a refusal
  std::string variable;  // "PALPATE_LIBHD"
  std::string install;   // "install the maker's OpenHaptics for Linux"
  std::string oldest;    // "OpenHaptics 3.0", which has all functions
  // Looked at in turn; a name without a folder is the loader's to find.
  std::vector<std::filesystem::path> places{};
  // What to do where a library that it needs is missing: a part of that one's name, and the remedy.
  std::vector<std::pair<std::string, std::string>> dependencies{};
};

enum class LibraryProblem : std::uint8_t {
  none,
  not_found,
  unreadable,
  not_a_library,
  static_library,  // an archive for linkers
  thirty_two_bit,
  other_machine,       // built for another processor
  missing_dependency,  // one of the libraries it needs itself
  missing_function,    // too old, or another library of that name
  not_loadable,        // anything else the loader says
};

struct LibraryFacts {
  const MakerLibrary* library = nullptr;  // lives as long as the program
  LibraryProblem problem = LibraryProblem::not_found;
  std::string file{};     // looked at; empty: none was found
  std::string detail{};   // the missing library, the missing functions, the processor, the loader's words
  std::string version{};  // as the library tells it; empty where it does not
  // Empty where there is no problem.
  std::string reason() const, remedy() const;
  // Both in a line, as a refusal.
  Error refusal() const;
};

// What an opened library is asked for.
class LibraryFunctions {
 public:
  explicit LibraryFunctions(void* handle) : handle_(handle) {}
  // Null, and remembered as missing, where the library has none of that name.
  template <typename Function>
  void take(const char* name, Function& function) {
    if (!take_if_any(name, function)) missing_ += (missing_.empty() ? "" : ", ") + std::string(name);
  }
  // False, and null, where it has none.
  template <typename Function>
  bool take_if_any(const char* name, Function& function) {
    function = reinterpret_cast<Function>(find(name));
    return function != nullptr;
  }
  const std::string& missing() const { return missing_; }  // "a, b"

 private:
  void* find(const char* name) const;
  void* handle_;
  std::string missing_;
};

// Takes the functions out of a library; gives its version, empty where it tells none. Not asked where one is missing.
struct LibraryReader {
  std::function<void(LibraryFunctions&)> take;
  std::function<std::string()> version;
};

// Looks at the file's head before the loader does, so that a library of another machine is named as such.
// Loads the library. Empty: the default search, which takes the first that works, and where none does tells of the first
// that is there.
LibraryFacts find_library(const MakerLibrary& library, const std::filesystem::path& file,
                          const LibraryReader& reader);

// The loader hands out the same library again, so there is one object for it as well.
template <typename Library>
class LoadedLibraries {
 public:
  template <typename Make>
  std::shared_ptr<Library> of(const LibraryFacts& facts, Make&& make) {
    const std::lock_guard lock(guard_);
    auto& library = loaded_[facts.file];
    if (!library) library = make();
    return library;
  }

 private:
  std::mutex guard_;
  std::map<std::string, std::shared_ptr<Library>> loaded_;
};

}  // namespace palpate::drivers::arms
