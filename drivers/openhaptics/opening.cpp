#include "drivers/openhaptics/opening.h"

#include <cmath>

#include "drivers/openhaptics/error_text.h"
#include "palpate/core/text.h"

namespace palpate::drivers::openhaptics {
namespace {

constexpr int kMostListed = 16;  // errors in the library's list that are looked at

std::string text_or_none(const char* text) { return text == nullptr ? "" : excerpt(text); }

}  // namespace

std::string device_words(const std::string& name) {
  return name.empty() ? "the default device" : fmt::format("device '{}'", excerpt(name));
}

std::string error_line(const std::string& name, hd::ErrorCode code, int internal) {
  const ErrorWords words = error_text(code);
  return fmt::format("arm openhaptics: {}: {} ({} 0x{:04x}, device's own code {}); {}", device_words(name),
                     words.reason, words.name, code, internal, words.remedy);
}

hd::ErrorInfo take_errors(const hd::Functions& hd) {
  hd::ErrorInfo newest = hd.get_error();
  for (int i = 0; i < kMostListed && newest.code != hd::kSuccess; ++i)
    if (hd.get_error().code == hd::kSuccess) break;
  return newest;
}

Expected<Opened> open_device(Library& library, const std::string& name) {
  const auto& hd = library.hd();
  Opened opened;
  hd::ErrorInfo error{};
  int input = 0, output = 0, style = 0;
  library.while_scheduler_rests([&] {
    take_errors(hd);  // of others
    opened.handle = hd.init_device(name.empty() ? nullptr : name.c_str());
    error = take_errors(hd);
    // A warm motor is no reason to stay closed.
    if (opened.handle == hd::kInvalidHandle || error_text(error.code).kind == ErrorKind::device) return;
    hd.make_current_device(opened.handle);
    hd.get_integerv(hd::kInputDof, &input);
    hd.get_integerv(hd::kOutputDof, &output);
    hd.get_integerv(hd::kCalibrationStyle, &style);
    hd.get_doublev(hd::kNominalMaxForce, &opened.facts.peak_n);
    hd.get_doublev(hd::kNominalMaxContinuousForce, &opened.facts.continuous_n);
    opened.facts.model = text_or_none(hd.get_string(hd::kModel));
    opened.facts.serial = text_or_none(hd.get_string(hd::kSerialNumber));
    opened.facts.driver = text_or_none(hd.get_string(hd::kDriverVersion));
    hd.enable(hd::kForceOutput);
    error = take_errors(hd);
  });
  if (opened.handle == hd::kInvalidHandle && error.code == hd::kSuccess)
    error.code = hd::kDeviceFault;  // some versions only say that there is no handle
  const auto refuse = [&](std::string message) -> tl::unexpected<Error> {
    if (opened.handle != hd::kInvalidHandle) hd.disable_device(opened.handle);
    return refused("{}", message);
  };
  if (error_text(error.code).kind == ErrorKind::device)
    return refuse(error_line(name, error.code, error.internal));
  if (input < 6 || output < 3)
    return refuse(fmt::format(
        "arm openhaptics: {}: measures {} directions and gives force in {}, 6 and 3 are expected; an arm "
        "whose gimbal has encoders is needed",
        device_words(name), input, output));
  if (!std::isfinite(opened.facts.peak_n) || opened.facts.peak_n <= 0.0)
    return refuse(fmt::format(
        "arm openhaptics: {}: states {} N as its peak force, more than 0 is expected; run the maker's setup "
        "program for this device",
        device_words(name), opened.facts.peak_n));
  opened.facts.name = name;
  opened.facts.library = library.facts().file;
  opened.facts.library_version = library.facts().version;
  const auto bits = static_cast<hd::Enum>(style);
  opened.calibration_style = (bits & hd::kAuto) != 0      ? hd::kAuto
                             : (bits & hd::kInkwell) != 0 ? hd::kInkwell
                                                          : hd::kEncoderReset;
  return opened;
}

Expected<ArmFacts> probe_arm(const ArmSettings& settings) {
  auto library = Library::load(settings.library);
  if (!library) return tl::unexpected(library.error());
  const std::lock_guard lock((*library)->calls());
  auto opened = open_device(**library, settings.name);
  if (!opened) return tl::unexpected(opened.error());
  (*library)->hd().disable_device(opened->handle);
  take_errors((*library)->hd());
  return opened->facts;
}

}  // namespace palpate::drivers::openhaptics
