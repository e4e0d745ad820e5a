#include "drivers/openhaptics/library.h"

#include "palpate/core/text.h"

namespace palpate::drivers::openhaptics {
namespace {

void take_all_functions(arms::LibraryFunctions& library, hd::Functions& hd) {
  library.take("hdInitDevice", hd.init_device);
  library.take("hdDisableDevice", hd.disable_device);
  library.take("hdMakeCurrentDevice", hd.make_current_device);
  library.take("hdBeginFrame", hd.begin_frame);
  library.take("hdEndFrame", hd.end_frame);
  library.take("hdGetError", hd.get_error);
  library.take("hdEnable", hd.enable);
  library.take("hdGetIntegerv", hd.get_integerv);
  library.take("hdGetDoublev", hd.get_doublev);
  library.take("hdGetString", hd.get_string);
  library.take("hdSetDoublev", hd.set_doublev);
  library.take("hdStartScheduler", hd.start_scheduler);
  library.take("hdStopScheduler", hd.stop_scheduler);
  library.take("hdScheduleAsynchronous", hd.schedule_asynchronous);
  library.take("hdUnschedule", hd.unschedule);
  library.take("hdCheckCalibration", hd.check_calibration);
  library.take("hdUpdateCalibration", hd.update_calibration);
}

LibraryFacts find(const std::filesystem::path& file, hd::Functions& hd) {
  return arms::find_library(maker_library(), file,
                            {[&hd](arms::LibraryFunctions& library) { take_all_functions(library, hd); },
                             [&hd] {
                               const char* version = hd.get_string(hd::kVersion);
                               return version == nullptr ? std::string() : excerpt(version);
                             }});
}

}  // namespace

const arms::MakerLibrary& maker_library() {
  static const std::string driver_remedy =
      "install the maker's device driver (Touch or PHANToM Device Driver), which brings it, then ldconfig";
  static const arms::MakerLibrary library{
      .file = "libHD.so",
      .product = "OpenHaptics",
      .driver = "arm openhaptics",
      .variable = "PALPATE_LIBHD",
      .install = "install the maker's OpenHaptics for Linux",
      .oldest = "OpenHaptics 3.0",
      .places = {"libHD.so", "/usr/lib/x86_64-linux-gnu/libHD.so", "/usr/lib/libHD.so", "/usr/lib64/libHD.so",
                 "/usr/local/lib/libHD.so", "/opt/OpenHaptics/usr/lib/libHD.so"},
      .dependencies = {{"PhantomIO", driver_remedy},
                       {"PHANToMIO", driver_remedy},
                       {"usb", "install libusb (apt install libusb-1.0-0 or libusb-0.1-4)"},
                       {"1394", "install the FireWire library (apt install libraw1394-11)"}}};
  return library;
}

LibraryFacts inspect_library(const std::filesystem::path& file) {
  hd::Functions unused{};
  return find(file, unused);
}

Expected<std::shared_ptr<Library>> Library::load(const std::filesystem::path& file) {
  hd::Functions functions{};
  LibraryFacts facts = find(file, functions);
  if (facts.problem != LibraryProblem::none) return tl::unexpected(facts.refusal());
  static arms::LoadedLibraries<Library> loaded;
  return loaded.of(facts, [&] { return std::shared_ptr<Library>(new Library(functions, facts)); });
}

void Library::use_scheduler() {
  if (scheduler_users_++ == 0) hd_.start_scheduler();
}

void Library::release_scheduler() {
  if (--scheduler_users_ == 0) hd_.stop_scheduler();
}

}  // namespace palpate::drivers::openhaptics
