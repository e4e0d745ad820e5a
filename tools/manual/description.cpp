#include "tools/manual/description.h"

#include <algorithm>
#include <string_view>

namespace palpate::tools::manual {
namespace {

bool contains(std::string_view text, std::string_view part) { return text.find(part) != text.npos; }

bool plain_word(const std::string& word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

std::vector<std::string> split(std::string_view text, std::string_view between) {
  std::vector<std::string> parts;
  for (auto at = text.find(between); at != text.npos; at = text.find(between)) {
    parts.emplace_back(text.substr(0, at));
    text.remove_prefix(at + between.size());
  }
  parts.emplace_back(text);
  return parts;
}

// Those that a check names ("TEXT:left, right"), or the type itself ("red|blue").
std::vector<std::string> choices_in(const std::string& type) {
  const auto colon = type.find(':');
  auto words = colon == type.npos ? split(type, "|") : split(std::string_view(type).substr(colon + 1), ", ");
  const bool some =
      (colon != type.npos || words.size() > 1) && std::all_of(words.begin(), words.end(), plain_word);
  return some ? words : std::vector<std::string>{};
}

// What the parser calls "FLOAT:0.1 to 60" is, to a person, "0.1 to 60".
std::string type_for_people(const std::string& type) {
  const auto colon = type.find(':');
  const std::string plain = type.substr(0, colon);
  const std::string name = plain == "TEXT"                     ? ""
                           : plain == "FLOAT"                  ? "NUMBER"
                           : plain == "UINT" || plain == "INT" ? "COUNT"
                                                               : plain;
  if (colon == type.npos) return name.empty() ? "TEXT" : name;
  return name.empty() ? type.substr(colon + 1) : name + " (" + type.substr(colon + 1) + ")";
}

Value value_in(const std::string& type) {
  for (const char* part : {"FILE", "GLOB", ".csv", ".toml", ".json"})
    if (contains(type, part)) return Value::file;
  if (type == "DIR" || type == "FOLDER") return Value::folder;
  // Not said what it is: most such words are names of files.
  return type == "TEXT" ? Value::file : Value::other;
}

Option describe(const CLI::Option& option) {
  Option described;
  for (const auto& name : option.get_snames()) described.names.push_back("-" + name);
  for (const auto& name : option.get_lnames()) described.names.push_back("--" + name);
  if (described.names.empty()) described.names.push_back(option.get_name(true));
  described.text = option.get_description();
  described.required = option.get_required();
  if (option.get_items_expected_max() == 0) return described;
  const std::string type = option.get_type_name();
  described.choices = choices_in(type);
  described.value = described.choices.empty() ? value_in(type) : Value::word;
  described.type = described.choices.empty() ? type_for_people(type) : joined(described.choices, "|");
  described.standard = option.get_default_str();
  return described;
}

Command describe(const CLI::App& app, std::vector<std::string> words) {
  Command command;
  command.text = app.get_description();
  for (const auto* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    (option->get_positional() && option->get_lnames().empty() ? command.arguments : command.options)
        .push_back(describe(*option));
  }
  for (const auto* below :
       app.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); })) {
    auto below_words = words;
    below_words.push_back(below->get_name());
    command.commands.push_back(describe(*below, std::move(below_words)));
  }
  command.words = std::move(words);
  return command;
}

}  // namespace

Command describe(const CLI::App& program) { return describe(program, {program.get_name()}); }

const Command* find(const Command& program, const std::vector<std::string>& words) {
  const Command* found = &program;
  for (const auto& word : words) {
    const auto& below = found->commands;
    const auto next =
        std::find_if(below.begin(), below.end(), [&](const auto& one) { return one.words.back() == word; });
    if (next == below.end()) return nullptr;
    found = &*next;
  }
  return found;
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  return CLI::detail::join(words, between);
}

}  // namespace palpate::tools::manual
