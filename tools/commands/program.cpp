#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>

#include "palpate/core/child_report.h"
#include "palpate/core/log.h"
#include "palpate/core/nearest.h"
#include "palpate/core/text.h"
#include "tools/commands/build_info.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"
#include "tools/commands/help_page.h"
#include "tools/commands/program.h"
#include "tools/commands/program_options.h"

namespace palpate::tools::commands {
namespace {
Action chosen;
}
void set_action(Action action) { chosen = std::move(action); }

namespace {
// What is wrong with a number that was written for this option; empty: nothing. "nan" and "inf" pass as
// numbers, and a comparison with a range lets the former through; a sign or too many digits wrap round.
std::string trouble_with(const CLI::Option& option, const std::string& text) {
  using CLI::detail::lexical_cast;
  const std::string type = option.get_type_name();  // with its range, where it has one
  if (type.starts_with("UINT")) {
    std::uint64_t value = 0;
    if (text.starts_with('-')) return "is below zero; a whole number from 0 on is expected, such as 1";
    if (text.size() > 19) return "is too large; a whole number of at most 19 digits is expected";
    return lexical_cast(text, value) ? "" : "a whole number from 0 on is expected, such as 1";
  }
  if (type.starts_with("INT")) {
    std::int64_t value = 0;
    return lexical_cast(text, value) ? "" : "a whole number is expected, such as 1";
  }
  const bool one = type.starts_with("FLOAT");
  if (!one && type.find(',') == std::string::npos) return "";
  double value = 0.0;
  if (!lexical_cast(text, value)) return one ? "a number is expected, such as 1.5" : "";
  return std::isfinite(value) ? "" : "a finite number is expected";
}

Expected<void> check_numbers(const CLI::App& command) {
  for (const auto* option : command.get_options())
    for (const auto& text : option->results())
      if (const auto trouble = trouble_with(*option, text); !trouble.empty())
        return wrong_use("{} '{}': {}; see --help", option->get_name(), excerpt(text), trouble);
  for (const auto* chosen_command : command.get_subcommands())
    if (auto fine = check_numbers(*chosen_command); !fine) return fine;
  return {};
}

// "calibrate arm"; the program itself by its own name.
std::string words_of(const CLI::App& command) {
  const auto* parent = command.get_parent();
  const bool below_another = parent != nullptr && parent->get_parent() != nullptr;
  return (below_another ? words_of(*parent) + ' ' : "") + command.get_name();
}

// No option of this command: the one that was meant is named where there is one like it.
std::string no_option(const CLI::App& command, const std::string& word) {
  std::vector<std::string> known;
  for (const auto* option : command.get_options())
    for (const auto& name : option->get_lnames()) known.push_back(name);
  const auto said = fmt::format("{}: no such option of '{}'", excerpt(word), words_of(command));
  // Without the dashes: they would make short names look alike.
  const auto begin = word.find_first_not_of('-');
  const auto bare = begin == std::string::npos ? "" : word.substr(begin, word.find('=') - begin);
  const auto meant = nearest(bare, known);
  if (!meant.empty()) return fmt::format("{}; did you mean --{}?", said, meant);
  return said + (command.get_require_subcommand_min() > 0 ? ", which expects a command" : "");
}

std::vector<std::string> commands_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const auto* other :
       command.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); }))
    names.push_back(other->get_name());
  return names;
}

// No command where one is expected, or a word too many.
std::string no_command(const CLI::App& command, const std::string& word) {
  if (command.get_require_subcommand_min() == 0) {
    std::error_code failed;
    // The shell makes many words of a pattern: the first of them is the option's, the others nobody's.
    const bool file = std::filesystem::exists(word, failed);
    return fmt::format("{}: '{}' takes no such word; {}", excerpt(word), words_of(command),
                       file ? "a pattern of files is written in quotes, such as '*.jpg'" : "leave it out");
  }
  const auto known = commands_of(command);
  if (const auto meant = nearest(word, known); !meant.empty())
    return fmt::format("{}: no such command; did you mean '{}'?", excerpt(word), meant);
  return fmt::format("{}: no such command; one of {} is expected", excerpt(word),
                     CLI::detail::join(known, ", "));
}

// The first word that nobody knows, as a complaint; empty: every word is known.
std::string unknown_word(const CLI::App& command) {
  for (const auto& word : command.remaining())
    if (word != "--") return word.starts_with('-') ? no_option(command, word) : no_command(command, word);
  for (const auto* chosen_command : command.get_subcommands())
    if (auto found = unknown_word(*chosen_command); !found.empty()) return found;
  return "";
}

// A word before --help that is no command; empty: help is asked for of what there is, or not asked for.
std::string unknown_before_help(const CLI::App& program, const std::vector<std::string>& words) {
  if (std::find(words.begin(), words.end(), "--help") == words.end() &&
      std::find(words.begin(), words.end(), "-h") == words.end())
    return "";
  const CLI::App* command = &program;
  for (const auto& word : words) {
    if (word.starts_with('-') || command->get_require_subcommand_min() == 0) return "";
    const auto next = command->get_subcommands([&](const CLI::App* one) { return one->get_name() == word; });
    if (next.empty()) return no_command(*command, word);
    command = next.front();
  }
  return "";
}

// Which command lacks the one that is to follow it; empty: none does.
std::string missing_command(const CLI::App& command) {
  if (const auto next = command.get_subcommands(); !next.empty()) return missing_command(*next.front());
  if (command.get_require_subcommand_min() == 0) return "";
  return fmt::format("'{}' expects a command; one of {}", words_of(command),
                     CLI::detail::join(commands_of(command), ", "));
}

constexpr std::size_t kLongestError = 8192;  // bytes

// To whoever reads standard error, and to the program that started this one.
void tell_error(const std::string& words) {
  const std::string message = excerpt(words, kLongestError);
  Log().write(LogLevel::error, message);
  tell_parent_error(message);
}

// What was printed may still be on its way: that the disk behind it is full shows only now.
int after_printing() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return 0;
  Log().error("standard output: writing failed ({}); free some space and try again", std::strerror(errno));
  return 1;
}

// Parses and runs the command that was chosen.
int run_command(CLI::App& program, std::vector<std::string> words) {
  if (const auto unknown = unknown_before_help(program, words); !unknown.empty()) {
    tell_error(unknown);
    return 2;
  }
  std::reverse(words.begin(), words.end());  // as CLI11 takes them
  try {
    program.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      program.exit(error);
      return after_printing();
    }
    // What is unknown is named before what is missing, which may be the same thing misspelt.
    std::string trouble = unknown_word(program);
    if (trouble.empty())
      if (const auto fine = check_numbers(program); !fine) trouble = fine.error().message;
    if (trouble.empty()) trouble = missing_command(program);
    if (trouble.empty()) trouble = error.what();
    const bool whole = trouble.ends_with('?') || trouble.ends_with("see --help");
    tell_error(trouble + (whole ? "" : "; see --help"));
    return 2;
  }
  auto done = check_numbers(program);
  if (done) done = chosen();
  if (done) return after_printing();
  tell_error(done.error().message);
  return done.error().exit_code();
}

}  // namespace

int run_program(int argc, char** argv, const std::function<void(plugin::Guests&)>& add_guests) {
  // A file that may not grow further is then an error of write(), not the end of the program.
  std::signal(SIGXFSZ, SIG_IGN);
  end_with_parent();
  try {
    std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    // Before anything is declared: a plug-in's drivers and applications are in the help and among the choices.
    const std::string typed = CLI::detail::join(words, " ");
    const auto options = take_program_options(words);
    auto done = open_log(options.value_or(ProgramOptions{}));
    if (done && !options) done = tl::unexpected(options.error());
    if (done) Log().debug("version {}, process {}: palpate {}", text_of(build_info()), ::getpid(), typed);
    if (done) done = gather_guests(add_guests, options->plugins);
    if (!done) {
      tell_error(done.error().message);
      return done.error().exit_code();
    }
    if (!words.empty() && words.front() == "help") {  // `palpate help calibrate arm`
      words.erase(words.begin());
      words.emplace_back("--help");
    }
    CLI::App program("palpate - high-precision augmented-reality haptics", "palpate");
    program.require_subcommand(1);
    program.set_version_flag("--version", "palpate " + text_of(build_info()));
    describe_program_options(program);
    add_commands(program);
    describe_help(program);
    return run_command(program, std::move(words));
  } catch (const std::exception& error) {
    tell_error(error.what());
    return 1;
  }
}

}  // namespace palpate::tools::commands
