#include "tools/manual/pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "palpate/core/file.h"

namespace palpate::tools::manual {
namespace {

// Text as troff shows it unchanged: a line that begins with a dot or an apostrophe would be a request, and a bare '-'
// a hyphen, with which no option can be copied.
std::string shown(std::string_view text) {
  std::string troff;
  if (text.starts_with('.') || text.starts_with('\'')) troff += "\\&";
  for (const char c : text) {
    if (c == '\\')
      troff += "\\e";
    else if (c == '-')
      troff += "\\-";
    else if (c == '\n')
      troff += ' ';
    else
      troff += c;
  }
  return troff;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return text;
}

std::string bold(std::string_view text) { return "\\fB" + shown(text) + "\\fR"; }
std::string slanted(std::string_view text) { return "\\fI" + shown(text) + "\\fR"; }

std::string reference(const std::string& page) { return ".BR " + shown(page) + " (1)"; }

std::string sentence(std::string text) {
  if (!text.empty() && text.back() != '.' && text.back() != '?') text += '.';
  return text;
}

void add_option(std::string& page, const Option& option) {
  std::vector<std::string> names;
  const bool dashed = option.names.front().starts_with('-');
  for (const auto& name : option.names) names.push_back(dashed ? bold(name) : slanted(name));
  page += ".TP\n" + joined(names, ", ");
  if (dashed && option.value != Value::none) page += ' ' + slanted(option.type);
  page += '\n' + shown(sentence(option.text));
  if (!dashed && !option.choices.empty()) page += "\nOne of " + shown(joined(option.choices, ", ")) + '.';
  if (option.required) page += "\nHas to be given.";
  if (!option.standard.empty()) page += "\nWithout it: " + bold(option.standard) + '.';
  page += '\n';
}

void add_synopsis(std::string& page, const Command& command) {
  page += ".SH SYNOPSIS\n" + bold(joined(command.words, " "));
  if (!command.options.empty()) page += " [" + slanted("OPTION") + " ...]";
  for (const auto& argument : command.arguments) {
    const auto name = slanted(argument.names.front());
    page += argument.required ? ' ' + name : " [" + name + ']';
  }
  if (!command.commands.empty()) page += ' ' + slanted("COMMAND") + " ...";
  page += '\n';
}

void add_commands(std::string& page, const Command& command) {
  if (command.commands.empty()) return;
  page += ".SH COMMANDS\n";
  for (const auto& below : command.commands)
    page += ".TP\n" + reference(page_name(below)) + '\n' + shown(sentence(below.text)) + '\n';
}

void add_options(std::string& page, const char* title, const std::vector<Option>& options) {
  if (options.empty()) return;
  page += std::string(".SH ") + title + '\n';
  for (const auto& option : options) add_option(page, option);
}

void add_end(std::string& page, const Command& command) {
  page +=
      ".SH EXIT STATUS\n.TP\n.B 0\nIt is done.\n"
      ".TP\n.B 1\nIt was refused: one line on standard error says what is wrong and what to do.\n"
      ".TP\n.B 2\nThe command was written wrongly, or a file that it names is not there; one line says what "
      "is.\n";
  page += ".SH SEE ALSO\n";
  if (command.words.size() == 1) {
    page += "The pages of the commands above.\n";
    return;
  }
  std::vector<std::string> above(command.words.begin(), command.words.end() - 1);
  page += reference(joined(above, "-")) + '\n';
}

}  // namespace

std::string page_name(const Command& command) { return joined(command.words, "-"); }

std::string manual_page(const Command& command, const std::string& version) {
  const std::string name = page_name(command);
  std::string page = fmt::format(".TH {} 1 \"\" \"{} {}\" \"User commands\"\n", shown(upper(name)),
                                 command.words.front(), version);
  page += ".SH NAME\n" + shown(name) + " \\- " + shown(command.text) + '\n';
  add_synopsis(page, command);
  add_commands(page, command);
  add_options(page, "ARGUMENTS", command.arguments);
  add_options(page, "OPTIONS", command.options);
  add_end(page, command);
  return page;
}

Expected<void> write_manual_pages(const Command& program, const std::string& version,
                                  const std::string& folder) {
  const auto file = std::filesystem::path(folder) / (page_name(program) + ".1");
  if (auto written = write_file(file.string(), manual_page(program, version)); !written) return written;
  for (const auto& below : program.commands)
    if (auto written = write_manual_pages(below, version, folder); !written) return written;
  return {};
}

}  // namespace palpate::tools::manual
