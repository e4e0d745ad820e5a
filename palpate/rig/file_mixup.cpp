#include "palpate/rig/file_mixup.h"

#include <algorithm>
#include <array>

namespace palpate::rig {

Expected<void> is_no_world_file(const TomlTable& file, const std::string& source) {
  // Tables of a laboratory that no rig file has.
  constexpr std::array kOfWorlds = {"world", "clocks", "tracker", "hand",
                                    "head",  "player", "scene",   "faults"};
  if (file.has("rig_version") ||
      std::none_of(kOfWorlds.begin(), kOfWorlds.end(), [&](const char* name) { return file.has(name); }))
    return {};
  return wrong_use(
      "{}: is a world file, which describes a simulated laboratory (--world FILE); a rig file is expected: "
      "`palpate demo` writes palpate-report/rig.toml, calibrated, `palpate rig new FILE` an empty one",
      source);
}

Expected<void> is_no_rig_file(const TomlTable& file, const std::string& source) {
  if (!file.has("rig_version")) return {};
  return wrong_use(
      "{}: is a rig file, which holds devices and calibrations (--rig FILE); a world file is expected: "
      "`palpate world new FILE` writes one",
      source);
}

}  // namespace palpate::rig
