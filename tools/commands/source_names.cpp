#include "tools/commands/source_names.h"

#include <map>
#include <utility>

namespace palpate::tools::commands {
namespace {

std::map<std::string, std::string>& source_names() {
  static std::map<std::string, std::string> names;
  return names;
}

}  // namespace

void name_source(const std::string& file, std::string name) { source_names()[file] = std::move(name); }

std::string with_sources_named(std::string text) {
  for (const auto& [file, name] : source_names())
    for (auto at = text.find(file); at != std::string::npos; at = text.find(file, at + name.size()))
      text.replace(at, file.size(), name);
  return text;
}

void with_sources_named(Json& json) {
  if (json.is_string()) json = with_sources_named(json.get<std::string>());
  if (json.is_structured())
    for (auto& part : json) with_sources_named(part);
}

}  // namespace palpate::tools::commands
