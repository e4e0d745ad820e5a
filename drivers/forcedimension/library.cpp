#include "drivers/forcedimension/library.h"

#include <cstdlib>
namespace palpate::drivers::forcedimension {
namespace {

namespace fs = std::filesystem;

void take_all_functions(arms::LibraryFunctions& library, dhd::Functions& dhd) {
  library.take("dhdGetDeviceCount", dhd.get_device_count);
  library.take("dhdOpenID", dhd.open_id);
  library.take("dhdClose", dhd.close);
  library.take("dhdGetSystemType", dhd.get_system_type);
  library.take("dhdGetSystemName", dhd.get_system_name);
  library.take("dhdGetSerialNumber", dhd.get_serial_number);
  library.take("dhdGetSDKVersion", dhd.get_sdk_version);
  library.take("dhdGetStatus", dhd.get_status);
  library.take("dhdEnableForce", dhd.enable_force);
  library.take("dhdGetPositionAndOrientationFrame", dhd.get_pose);
  library.take("dhdGetButtonMask", dhd.get_button_mask);
  library.take("dhdSetForceAndTorqueAndGripperForce", dhd.set_force);
  library.take("dhdErrorGetLastStr", dhd.get_last_error);
  library.take_if_any("dhdHasWrist", dhd.has_wrist);
  library.take_if_any("dhdIsLeftHanded", dhd.is_left_handed);
  library.take_if_any("dhdGetMaxForce", dhd.get_max_force);
  library.take_if_any("dhdEnableExpertMode", dhd.enable_expert_mode);
  library.take_if_any("dhdDisableExpertMode", dhd.disable_expert_mode);
  library.take_if_any("dhdSetWatchdog", dhd.set_watchdog);
}

// The kit is unpacked wherever its user likes; FDSDK says where, as for the maker's own examples. Newer ones have all of it
// in libdrd, older ones in libdhd. An archive comes last: a person is then told that it is one.
std::vector<fs::path> places() {
  std::vector<fs::path> found{"libdhd.so", "libdrd.so", "libdhd.so.3", "libdrd.so.3"};
  std::vector<fs::path> folders{"/usr/local/lib", "/usr/lib/x86_64-linux-gnu", "/usr/lib"};
  if (const char* kit = std::getenv("FDSDK"); kit != nullptr && *kit != '\0') {
    std::error_code ignored;
    const fs::path release = fs::path(kit) / "lib" / "release";
    for (const auto& entry : fs::directory_iterator(release, ignored)) folders.push_back(entry.path());
  }
  for (const char* ending : {".so", ".so.3", ".a"})
    for (const auto& folder : folders)
      for (const char* name : {"libdhd", "libdrd"}) found.push_back(folder / (std::string(name) + ending));
  return found;
}

arms::LibraryFacts find(const fs::path& file, dhd::Functions& dhd) {
  return arms::find_library(maker_library(), file,
                            {[&dhd](arms::LibraryFunctions& library) { take_all_functions(library, dhd); },
                             [&dhd] {
                               int major = 0, minor = 0, release = 0, revision = 0;
                               dhd.get_sdk_version(&major, &minor, &release, &revision);
                               return fmt::format("{}.{}.{}", major, minor, release);
                             }});
}

}  // namespace

const arms::MakerLibrary& maker_library() {
  static const arms::MakerLibrary library{
      .file = "libdhd.so",
      .product = "Force Dimension's SDK",
      .driver = "arm forcedimension",
      .variable = "PALPATE_LIBDHD",
      .install = "install the maker's SDK for Linux (libdhd.so or libdrd.so)",
      .oldest = "version 3.17 of the SDK",
      .places = places(),
      .dependencies = {{"usb", "install libusb (apt install libusb-1.0-0)"}}};
  return library;
}

arms::LibraryFacts inspect_library(const fs::path& file) {
  dhd::Functions unused{};
  return find(file, unused);
}

Expected<std::shared_ptr<Library>> Library::load(const fs::path& file) {
  dhd::Functions functions{};
  arms::LibraryFacts facts = find(file, functions);
  if (facts.problem != arms::LibraryProblem::none) return tl::unexpected(facts.refusal());
  static arms::LoadedLibraries<Library> loaded;
  return loaded.of(facts, [&] { return std::shared_ptr<Library>(new Library(functions, facts)); });
}

}  // namespace palpate::drivers::forcedimension
