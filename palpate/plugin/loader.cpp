#include "palpate/plugin/loader.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/auxv.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iterator>
#include <utility>

#include "palpate/core/text.h"
#include "palpate/plugin/build.h"
#include "palpate/plugin/entry.h"

namespace palpate::plugin {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kLayout[] = PALPATE_LAYOUT;
constexpr std::size_t kLongest = 400;  // bytes of the words of others

// GCC and clang follow one C++ ABI, Itanium's: what they make of one source, with the standard library and the options that
// `options` tells, lies and is named alike, so that one may call the other.
bool of_one_abi(const char* a, const char* b) {
  const auto family = [](std::string_view compiler) {
    return compiler.starts_with("gcc ") || compiler.starts_with("clang ");
  };
  return a != nullptr && b != nullptr && (std::strcmp(a, b) == 0 || (family(a) && family(b)));
}

std::string text_of(const char* words) { return words == nullptr ? "nothing" : excerpt(words, 100); }

// What a plug-in tells of itself fits this program; else what does not.
Expected<void> check_build(const std::string& file, const PalpatePlugin* told) {
  if (told == nullptr)
    return refused("plug-in {}: tells nothing of itself; build it with palpate_add_plugin()", file);
  if (told->abi != PALPATE_PLUGIN_ABI || told->size != sizeof(PalpatePlugin))
    return refused(
        "plug-in {}: its entry has version {} and {} bytes, {} and {} are expected; build it with the "
        "headers of Palpate {}",
        file, told->abi, told->size, PALPATE_PLUGIN_ABI, sizeof(PalpatePlugin), PALPATE_RELEASE);
  const auto differs = [](const char* a, const char* b) { return a == nullptr || std::strcmp(a, b) != 0; };
  if (differs(told->release, PALPATE_RELEASE))
    return refused(
        "plug-in {}: is made for Palpate {}, and this is {}; build it with the headers of this release", file,
        text_of(told->release), PALPATE_RELEASE);
  if (!of_one_abi(told->compiler, PALPATE_COMPILER))
    return refused("plug-in {}: is compiled by {}, and this program by {}; use GCC or clang", file,
                   text_of(told->compiler), PALPATE_COMPILER);
  if (differs(told->options, PALPATE_BUILD_OPTIONS))
    return refused("plug-in {}: is compiled for {}, and this program for {}; use the same options", file,
                   text_of(told->options), PALPATE_BUILD_OPTIONS);
  if (!std::equal(std::begin(kLayout), std::end(kLayout), std::begin(told->layout)))
    return refused(
        "plug-in {}: its types are of other sizes than this program's; build it with this program's own "
        "headers",
        file);
  if (told->name == nullptr || *told->name == '\0' || told->add_guests == nullptr)
    return refused("plug-in {}: has no name, or adds nothing; build it with palpate_add_plugin()", file);
  return {};
}

// What a loaded library tells of itself, if it fits.
Expected<const PalpatePlugin*> ask(void* library, const std::string& file) {
  void* symbol = dlsym(library, PALPATE_PLUGIN_ENTRY);
  if (symbol == nullptr)
    return refused("plug-in {}: is a library without the function {}; build it with palpate_add_plugin()",
                   file, PALPATE_PLUGIN_ENTRY);
  const PalpatePlugin* told = reinterpret_cast<PalpatePluginEntry>(symbol)();
  if (auto fits = check_build(file, told); !fits) return tl::unexpected(fits.error());
  return told;
}

// The library, loaded at once and for good.
Expected<const PalpatePlugin*> open(const std::string& file) {
  if (void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE)) return ask(library, file);
  const char* said = dlerror();
  const std::string why = excerpt(said == nullptr ? "no reason is told" : said, kLongest);
  // One of another release lacks functions that this program has not; it can still say itself what it is.
  if (void* library = dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL | RTLD_NODELETE))
    if (auto told = ask(library, file); !told) return told;
  return refused("plug-in {}: cannot be loaded ({}); is it made for Palpate {}, by palpate_add_plugin()?",
                 file, why, PALPATE_RELEASE);
}

// What add() has added to the end of `after`.
template <typename Items, typename Name>
std::vector<std::string> added(const Items& before, const Items& after, Name name) {
  std::vector<std::string> names;
  for (std::size_t i = before.size(); i < after.size(); ++i) names.push_back(name(after[i]));
  return names;
}

// Whoever may write a file or folder, said of the canonical path of one.
Expected<void> check_one(const fs::path& path, bool folder) {
  struct stat found {};
  if (lstat(path.c_str(), &found) != 0)
    return wrong_use("plug-in {}: cannot be looked at ({})", path.string(), std::strerror(errno));
  const char* kind = folder ? "folder" : "file";
  if (found.st_uid != 0 && found.st_uid != geteuid())
    return refused(
        "plug-in: the {} {} belongs to user {}, who is neither you nor root; copy the plug-in into a folder "
        "of yours",
        kind, path.string(), found.st_uid);
  const bool others = (found.st_mode & (S_IWGRP | S_IWOTH)) != 0;
  if (others && !(folder && (found.st_mode & S_ISVTX) != 0))
    return refused("plug-in: others may write to the {} {}; chmod go-w {}", kind, path.string(),
                   path.string());
  return {};
}

fs::path home() {
  const char* folder = secure_getenv("HOME");
  return folder == nullptr ? "" : folder;
}

}  // namespace

bool has_rights_of_its_own() { return getauxval(AT_SECURE) != 0; }

Expected<void> check_only_owner_writes(const fs::path& file) {
  if (auto fine = check_one(file, fs::is_directory(file)); !fine) return fine;
  for (fs::path folder = file.parent_path();; folder = folder.parent_path()) {
    if (auto fine = check_one(folder, true); !fine) return fine;
    if (folder == folder.root_path()) return {};
  }
}

const Loaded* Report::origin_of_application(std::string_view name) const {
  for (const Loaded& one : loaded)
    if (std::find(one.applications.begin(), one.applications.end(), name) != one.applications.end())
      return &one;
  return nullptr;
}

const Loaded* Report::origin_of_driver(std::string_view scheme) const {
  for (const Loaded& one : loaded)
    if (std::find(one.drivers.begin(), one.drivers.end(), scheme) != one.drivers.end()) return &one;
  return nullptr;
}

Expected<void> load(const fs::path& named, Guests& guests, Report& report) {
  std::error_code none;
  const fs::path file = fs::canonical(named, none);
  if (none || !fs::is_regular_file(file, none))
    return wrong_use("plug-in {}: no such file; a library that palpate_add_plugin() has made is expected",
                     excerpt(named.string(), kLongest));
  const auto same = [&file](const Loaded& one) { return one.file == file; };
  if (std::any_of(report.loaded.begin(), report.loaded.end(), same)) return {};
  if (auto fine = check_only_owner_writes(file); !fine) return fine;
  const auto told = open(file.string());
  if (!told) return tl::unexpected(told.error());
  Guests with = guests;  // all of it or nothing
  try {
    (*told)->add_guests(&with);
  } catch (const std::exception& thrown) {
    return refused("plug-in {}: {}", file.string(), excerpt(thrown.what(), kLongest));
  } catch (...) {
    return refused("plug-in {}: threw what is no std::exception", file.string());
  }
  Loaded one{file, (*told)->name,
             added(guests.applications.specs(), with.applications.specs(),
                   [](const auto& spec) { return spec.name; }),
             added(guests.drivers.drivers(), with.drivers.drivers(),
                   [](const auto& driver) { return driver.scheme; })};
  if (one.applications.empty() && one.drivers.empty())
    return refused("plug-in {}: adds neither an application nor a driver", file.string());
  guests = std::move(with);
  report.loaded.push_back(std::move(one));
  return {};
}

void load_folder(const fs::path& named, Guests& guests, Report& report) {
  std::error_code none;
  const fs::path folder = fs::canonical(named, none);
  if (none || !fs::is_directory(folder, none)) return;
  if (auto fine = check_only_owner_writes(folder); !fine) {
    report.skipped.push_back(fine.error().message);
    return;
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, none))
    if (entry.path().extension() == ".so") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files)
    if (auto done = load(file, guests, report); !done) report.skipped.push_back(done.error().message);
}

SearchPath search_path(const fs::path& system) {
  SearchPath path;
  if (const char* listed = secure_getenv("PALPATE_PLUGIN_PATH")) {
    std::string_view rest(listed);
    while (!rest.empty()) {
      const auto end = std::min(rest.find(':'), rest.size());
      if (end > 0) path.named.emplace_back(rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  if (const fs::path folder = home(); !folder.empty())
    path.folders.push_back(folder / ".local/lib/palpate/plugins");
  path.folders.push_back(system);
  return path;
}

void load_all(const SearchPath& path, Guests& guests, Report& report) {
  std::error_code none;
  for (const fs::path& named : path.named) {
    if (fs::is_directory(named, none)) {
      load_folder(named, guests, report);
    } else if (auto done = load(named, guests, report); !done) {
      report.skipped.push_back(done.error().message);
    }
  }
  for (const fs::path& folder : path.folders) load_folder(folder, guests, report);
}

}  // namespace palpate::plugin
