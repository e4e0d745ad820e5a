#include "palpate/rig/file_mixup.h"

#include <algorithm>
#include <array>

#include "palpate/core/file_form.h"

namespace palpate::rig {
namespace {

constexpr std::string_view kRigExpected =
    "a rig file is expected: `palpate demo` writes palpate-report/rig.toml, calibrated, "
    "`palpate rig new FILE` an empty one";

}  // namespace

Expected<void> is_no_world_file(const TomlTable& file, const std::string& source) {
  // Tables of a laboratory that no rig file has.
  constexpr std::array kOfWorlds = {"world", "clocks", "tracker", "hand",
                                    "head",  "player", "scene",   "faults"};
  if (file.has("rig_version") ||
      std::none_of(kOfWorlds.begin(), kOfWorlds.end(), [&](const char* name) { return file.has(name); }))
    return {};
  return wrong_use("{}: is a world file, which describes a simulated laboratory (--world FILE); {}", source,
                   kRigExpected);
}

Expected<void> is_no_rig_file(const TomlTable& file, const std::string& source) {
  if (!file.has("rig_version")) return {};
  return wrong_use(
      "{}: is a rig file, which holds devices and calibrations (--rig FILE); a world file is expected: "
      "`palpate world new FILE` writes one",
      source);
}

std::optional<Error> file_of_another_form(std::string_view content, const std::string& source) {
  const auto form = form_of(content);
  if (form == FileForm::unknown || is_toml(form)) return std::nullopt;
  return wrong_use("{}: {}; {}", source, words_of(form), kRigExpected).value();
}

}  // namespace palpate::rig
