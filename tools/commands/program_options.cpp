#include "tools/commands/program_options.h"

#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "palpate/core/log.h"

namespace palpate::tools::commands {
namespace {

constexpr const char* kLogVariable = "PALPATE_LOG";

// The value of `option` where the word at `i` is it or begins with it; then `i` is that of the value's word.
bool take_value(const std::vector<std::string>& words, std::size_t& i, std::string_view option,
                std::string& value) {
  const std::string& word = words[i];
  if (word == option) {
    value = i + 1 < words.size() ? words[++i] : "";
    return true;
  }
  if (!word.starts_with(option) || word[option.size()] != '=') return false;
  value = word.substr(option.size() + 1);
  return true;
}

}  // namespace

Expected<ProgramOptions> take_program_options(std::vector<std::string>& words) {
  ProgramOptions options;
  std::vector<std::string> rest;
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::string value;
    if (words[i] == "--") {
      rest.insert(rest.end(), words.begin() + static_cast<std::ptrdiff_t>(i), words.end());
      break;
    }
    if (take_value(words, i, "--plugin", value)) {
      if (value.empty()) return wrong_use("--plugin: a file is expected, such as --plugin ./jelly.so");
      options.plugins.push_back(std::move(value));
    } else if (take_value(words, i, "--log", value)) {
      if (value.empty()) return wrong_use("--log: a file is expected, such as --log ./palpate.log");
      options.log = std::move(value);
    } else {
      rest.push_back(words[i]);
    }
  }
  words = std::move(rest);
  return options;
}

Expected<void> open_log(const ProgramOptions& options) {
  log_to_standard_error();
  std::string file = options.log;
  if (const char* inherited = secure_getenv(kLogVariable); file.empty() && inherited != nullptr)
    file = inherited;
  if (file.empty()) return {};
  if (auto opened = log_to_file(file); !opened) return opened;
  std::error_code none;
  ::setenv(kLogVariable, std::filesystem::absolute(file, none).c_str(), 1);
  return {};
}

void describe_program_options(CLI::App& program) {
  program
      .add_option("--plugin", "Load this plug-in, before or after the command; as often as there are some")
      ->type_name("FILE");
  program
      .add_option(
          "--log",
          "Add what is told on standard error, and more for who looks for a fault, to this file, with "
          "time and level")
      ->type_name("FILE");
}

}  // namespace palpate::tools::commands
