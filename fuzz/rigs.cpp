// Rig files: what is read can be written, and reads back as the same text.
#include "fuzz/check.h"
#include "palpate/rig/rig.h"

namespace palpate::fuzz {

Refusals rigs(std::string_view file) {
  Refusals refusals;
  const auto rig = rig::parse_rig(file, "rig.toml");
  if (!answered(rig, refusals)) return refusals;
  const auto text = rig::rig_text(*rig);
  const auto again = rig::parse_rig(text, "written.toml");
  if (!again) std::fprintf(stderr, "%s\n%s\n", again.error().message.c_str(), text.c_str());
  hold(again.has_value(), "a rig that was read can be written and read again");
  for (const auto& missing : rig::missing_parts(*again))
    hold(!missing.remedy.empty(), "a missing part has a remedy");
  return refusals;
}

}  // namespace palpate::fuzz
