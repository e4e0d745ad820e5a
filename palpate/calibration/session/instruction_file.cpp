#include "palpate/calibration/session/instruction_file.h"

#include <cerrno>
#include <cstring>

#include "palpate/core/no_pipe_signal.h"
#include "palpate/device/person_json.h"

namespace palpate::calibration::session {
namespace {

constexpr double kSeenEvery = 1.0;  // s: a marker may come and go with each frame

}  // namespace

Expected<std::shared_ptr<InstructionFile>> InstructionFile::open(const std::string& name) {
  auto opened = std::make_shared<InstructionFile>();
  if (name.empty()) return opened;
  opened->file_.reset(std::fopen(name.c_str(), "we"));
  if (!opened->file_) return wrong_use("--instructions {}: {}", name, std::strerror(errno));
  return opened;
}

void InstructionFile::write(const Json& instruction) {
  if (!file_) return;
  const NoPipeSignal quiet;
  std::fprintf(file_.get(), "%s\n", instruction.dump().c_str());
  if (std::fflush(file_.get()) != 0) file_.reset();
}

void InstructionFile::write(const device::Request& request, const std::string& text) {
  Json json = device::json_of(request);
  json["text"] = text;
  write(json);
}

void InstructionFile::write_seen(const PersonView& view) {
  if (!seen_.is_null() && view.now_s < seen_s_ + kSeenEvery) return;
  Json seen = {{"stylus", view.stylus.seen}, {"pointer", view.pointer.seen}, {"camera", view.head.seen}};
  if (seen == seen_) return;
  seen_ = seen;
  seen_s_ = view.now_s;
  write({{"seen", std::move(seen)}});
}

}  // namespace palpate::calibration::session
