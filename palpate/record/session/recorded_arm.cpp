#include "palpate/record/session/recorded_arm.h"

#include "palpate/record/session/recorded_tables.h"
#include "palpate/rig/rig.h"

namespace palpate::record::session {

std::optional<device::ArmModel> recorded_arm(const std::filesystem::path& recording) {
  const auto text = find_attachment(recording, "rig.toml");
  if (!text || !*text) return std::nullopt;
  const auto rig = rig::parse_rig(**text, "rig.toml");
  return rig ? std::optional(rig->nominal_arm) : std::nullopt;
}

}  // namespace palpate::record::session
