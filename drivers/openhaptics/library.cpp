#include "drivers/openhaptics/library.h"

#include <dlfcn.h>
#include <elf.h>

#include <cstdlib>
#include <fstream>
#include <map>

#include "palpate/core/text.h"

namespace palpate::drivers::openhaptics {
namespace {

namespace fs = std::filesystem;

#if defined(__x86_64__)
constexpr std::uint16_t kOwnMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr std::uint16_t kOwnMachine = EM_AARCH64;
#else
constexpr std::uint16_t kOwnMachine = EM_NONE;  // not told apart: the loader's words have to do
#endif

std::string machine_name(std::uint16_t machine) {
  switch (machine) {
    case EM_X86_64:
      return "x86_64";
    case EM_AARCH64:
      return "aarch64";
    case EM_386:
      return "i386";
    case EM_ARM:
      return "arm";
    default:
      return fmt::format("machine {}", machine);
  }
}

// What the head of the file says; `none` where nothing speaks against loading it.
LibraryFacts look_at_head(const fs::path& file) {
  LibraryFacts facts;
  facts.file = file.string();
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return facts;
  facts.problem = LibraryProblem::unreadable;
  if (!fs::is_regular_file(file, ignored)) return facts;  // opening alone may wait for a pipe's other end
  std::ifstream in(file, std::ios::binary);
  unsigned char head[20] = {};
  if (!in.is_open()) return facts;
  in.read(reinterpret_cast<char*>(head), sizeof head);
  const bool elf = in.gcount() == sizeof head && head[0] == ELFMAG0 && head[1] == ELFMAG1 &&
                   head[2] == ELFMAG2 && head[3] == ELFMAG3;
  const auto machine = static_cast<std::uint16_t>(head[18] | head[19] << 8);
  facts.problem = LibraryProblem::none;
  if (!elf) {
    facts.problem = LibraryProblem::not_a_library;
  } else if (head[EI_CLASS] == ELFCLASS32 && sizeof(void*) == 8) {
    facts.problem = LibraryProblem::thirty_two_bit;
  } else if (kOwnMachine != EM_NONE && machine != kOwnMachine) {
    facts.problem = LibraryProblem::other_machine;
    facts.detail = machine_name(machine);
  }
  return facts;
}

// The loader tells of a library that is missing as "NAME: cannot open shared object file: ...".
std::string missing_library(const std::string& words, const std::string& file) {
  const auto end = words.find(": cannot open shared object file");
  if (end == std::string::npos) return "";
  const std::string name = words.substr(0, end);
  return name == file ? "" : name;
}

template <typename Function>
void take_function(void* library, const char* name, Function& function, std::string& missing) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  if (function == nullptr) missing += (missing.empty() ? "" : ", ") + std::string(name);
}

// Names of those that are not there.
std::string take_all_functions(void* library, hd::Functions& hd) {
  std::string missing;
  take_function(library, "hdInitDevice", hd.init_device, missing);
  take_function(library, "hdDisableDevice", hd.disable_device, missing);
  take_function(library, "hdMakeCurrentDevice", hd.make_current_device, missing);
  take_function(library, "hdBeginFrame", hd.begin_frame, missing);
  take_function(library, "hdEndFrame", hd.end_frame, missing);
  take_function(library, "hdGetError", hd.get_error, missing);
  take_function(library, "hdEnable", hd.enable, missing);
  take_function(library, "hdGetIntegerv", hd.get_integerv, missing);
  take_function(library, "hdGetDoublev", hd.get_doublev, missing);
  take_function(library, "hdGetString", hd.get_string, missing);
  take_function(library, "hdSetDoublev", hd.set_doublev, missing);
  take_function(library, "hdStartScheduler", hd.start_scheduler, missing);
  take_function(library, "hdStopScheduler", hd.stop_scheduler, missing);
  take_function(library, "hdScheduleAsynchronous", hd.schedule_asynchronous, missing);
  take_function(library, "hdUnschedule", hd.unschedule, missing);
  take_function(library, "hdCheckCalibration", hd.check_calibration, missing);
  take_function(library, "hdUpdateCalibration", hd.update_calibration, missing);
  return missing;
}

// One file, or a name for the loader to find.
LibraryFacts open_file(const fs::path& file, hd::Functions& hd) {
  LibraryFacts facts;
  facts.file = file.string();
  if (file.has_parent_path()) {
    facts = look_at_head(file);
    if (facts.problem != LibraryProblem::none) return facts;
  }
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* said = dlerror();
    const std::string words = said == nullptr ? "no reason given" : said;
    facts.detail = missing_library(words, facts.file);
    if (!facts.detail.empty()) {
      facts.problem = LibraryProblem::missing_dependency;
    } else if (!file.has_parent_path() && words.find("cannot open shared object") != std::string::npos) {
      facts.problem = LibraryProblem::not_found;
      facts.file.clear();
    } else {
      facts.problem = LibraryProblem::not_loadable;
      facts.detail = excerpt(words, 200);
    }
    return facts;
  }
  facts.detail = take_all_functions(library, hd);
  facts.problem = facts.detail.empty() ? LibraryProblem::none : LibraryProblem::missing_function;
  if (facts.problem == LibraryProblem::none) {
    const char* version = hd.get_string(hd::kVersion);
    if (version != nullptr) facts.version = excerpt(version);
  }
  return facts;
}

// The named one; or the first that works; or, where none does, the first that is there.
LibraryFacts find_library(const fs::path& asked, hd::Functions& hd) {
  if (!asked.empty()) return open_file(fs::absolute(asked), hd);
  if (const char* named = std::getenv("PALPATE_LIBHD"); named != nullptr && *named != '\0')
    return open_file(fs::absolute(named), hd);
  LibraryFacts first;
  for (const char* place :
       {"libHD.so", "/usr/lib/x86_64-linux-gnu/libHD.so", "/usr/lib/libHD.so", "/usr/lib64/libHD.so",
        "/usr/local/lib/libHD.so", "/opt/OpenHaptics/usr/lib/libHD.so"}) {
    LibraryFacts facts = open_file(place, hd);
    if (facts.problem == LibraryProblem::none) return facts;
    if (first.problem == LibraryProblem::not_found) first = facts;
  }
  if (first.problem == LibraryProblem::not_found) first.file.clear();
  return first;
}

}  // namespace

std::string LibraryFacts::reason() const {
  switch (problem) {
    case LibraryProblem::none:
      return "";
    case LibraryProblem::not_found:
      return file.empty() ? "libHD.so of OpenHaptics is not on this machine" : file + " is not there";
    case LibraryProblem::unreadable:
      return file + " cannot be read";
    case LibraryProblem::not_a_library:
      return file + " is no shared library";
    case LibraryProblem::thirty_two_bit:
      return file + " is a 32-bit library, this program has 64 bits";
    case LibraryProblem::other_machine:
      return fmt::format("{} is built for {}, this program for {}", file, detail, machine_name(kOwnMachine));
    case LibraryProblem::missing_dependency:
      return fmt::format("{} needs {}, which is not on this machine", file, detail);
    case LibraryProblem::missing_function:
      return fmt::format("{} lacks {}", file, detail);
    case LibraryProblem::not_loadable:
      return fmt::format("{} cannot be loaded: {}", file, detail);
  }
  return "";
}

std::string LibraryFacts::remedy() const {
  switch (problem) {
    case LibraryProblem::none:
      return "";
    case LibraryProblem::not_found:
      return "install the maker's OpenHaptics for Linux, or name the file: PALPATE_LIBHD=/path/libHD.so";
    case LibraryProblem::unreadable:
      return "give yourself the right to read it, or name another with PALPATE_LIBHD";
    case LibraryProblem::not_a_library:
      return "name OpenHaptics' libHD.so with PALPATE_LIBHD";
    case LibraryProblem::thirty_two_bit:
    case LibraryProblem::other_machine:
      return "install OpenHaptics for this machine's processor, or name another file with PALPATE_LIBHD";
    case LibraryProblem::missing_dependency:
      if (detail.find("PhantomIO") != std::string::npos || detail.find("PHANToMIO") != std::string::npos)
        return "install the maker's device driver (Touch or PHANToM Device Driver), which brings it, then "
               "ldconfig";
      if (detail.find("usb") != std::string::npos)
        return "install libusb (apt install libusb-1.0-0 or libusb-0.1-4)";
      if (detail.find("1394") != std::string::npos)
        return "install the FireWire library (apt install libraw1394-11)";
      return "install the package that has it (apt-file search " + detail + "), then ldconfig";
    case LibraryProblem::missing_function:
      return "install OpenHaptics 3.0 or newer, or name its libHD.so with PALPATE_LIBHD";
    case LibraryProblem::not_loadable:
      return "install OpenHaptics anew, or name another libHD.so with PALPATE_LIBHD";
  }
  return "";
}

LibraryFacts inspect_library(const fs::path& file) {
  hd::Functions unused{};
  return find_library(file, unused);
}

Expected<std::shared_ptr<Library>> Library::load(const fs::path& file) {
  hd::Functions functions{};
  LibraryFacts facts = find_library(file, functions);
  if (facts.problem != LibraryProblem::none)
    return refused("arm openhaptics: {}; {}", facts.reason(), facts.remedy());
  // The loader hands out the same library again, so there is one object for it as well.
  static std::mutex guard;
  static std::map<std::string, std::shared_ptr<Library>> loaded;
  const std::lock_guard lock(guard);
  auto& library = loaded[facts.file];
  if (!library) library.reset(new Library(functions, std::move(facts)));
  return library;
}

void Library::use_scheduler() {
  if (scheduler_users_++ == 0) hd_.start_scheduler();
}

void Library::release_scheduler() {
  if (--scheduler_users_ == 0) hd_.stop_scheduler();
}

}  // namespace palpate::drivers::openhaptics
