// Which device, with which files, as a person names it.
#include <filesystem>

#include "drivers/ndi/protocol.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"

namespace palpate::drivers::ndi {

Place split_place(std::string_view text) {
  Place place;
  const auto slash = text.find('/');
  place.server = std::string(text.substr(0, slash));
  if (slash == std::string_view::npos || slash + 1 == text.size()) return place;
  for (text.remove_prefix(slash + 1);;) {
    const auto comma = text.find(',');
    place.files.emplace_back(text.substr(0, comma));
    if (comma == std::string_view::npos) return place;
    text.remove_prefix(comma + 1);
  }
}

Expected<std::vector<Definition>> read_definitions(const std::vector<std::string>& files) {
  std::vector<Definition> definitions;
  for (const auto& file : files) {
    if (file.empty())
      return wrong_use("a tool's definition file without a name; HOST:PORT/FILE.rom,FILE.rom is expected");
    auto bytes = read_file(file, Definition::kMostBytes);
    if (!bytes) return tl::unexpected(bytes.error());
    if (bytes->empty())
      return wrong_use("{}: is empty; a tool's definition file is expected", excerpt(file, 160));
    auto name = std::filesystem::path(file).stem().string().substr(0, kMostNameBytes);
    if (name.empty() || !is_plain(name))
      return wrong_use("{}: its name is to be the tool's; letters before .rom are expected",
                       excerpt(file, 160));
    definitions.push_back({std::move(name), std::move(*bytes)});
  }
  return definitions;
}

}  // namespace palpate::drivers::ndi
