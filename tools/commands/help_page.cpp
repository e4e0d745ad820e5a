#include "tools/commands/help_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::tools::commands {
namespace {

constexpr std::size_t kWordsAt = 32, kLineEnds = 118;  // of the words beside an option; of a line

struct Named {
  std::string_view name, takes;
};
// What an option takes whose command says no more than that it is a text.
constexpr std::array<Named, 21> kTakes{
    {{"rig", "FILE"},       {"json", "FILE"},         {"world", "FILE"},      {"settings", "FILE"},
     {"mesh", "FILE"},      {"trace", "FILE"},        {"exposures", "FILE"},  {"record", "FILE"},
     {"learning", "FILE"},  {"instructions", "FILE"}, {"board", "BOARD"},     {"out", "PATH"},
     {"keys", "FOLDER"},    {"listen", "ADDRESS"},    {"connect", "ADDRESS"}, {"server-key", "KEY"},
     {"arm", "DEVICE"},     {"tracker", "DEVICE"},    {"camera", "DEVICE"},   {"right-camera", "DEVICE"},
     {"app", "APPLICATION"}}};

// The command line that follows "palpate " for the commands that people begin with.
struct Example {
  std::string_view command, line, does;
};
constexpr std::array<Example, 18> kExamples{
    {{"demo", "demo --quick --headless --out first",
      "everything once, without a window; then open first/report.html"},
     {"lockstep", "lockstep --app touch --seed 3 --record play.mcap --json play.json",
      "figures of a play, and its states"},
     {"play", "play --rig desk.rig.toml --camera v4l2", "ping-pong over the board on your desk"},
     {"physics", "physics --rig palpate-report/rig.toml --app touch", "beside `palpate world run`"},
     {"graphics", "graphics --rig palpate-report/rig.toml --window --mouse", "beside those two"},
     {"world run", "world run --name lab --seed 1",
      "the devices, for physics and graphics in other terminals"},
     {"world sample", "world sample arm --out arm", "files to try `palpate calibrate arm` with"},
     {"rig new", "rig new my.rig.toml", "a commented template"},
     {"rig check", "rig check my.rig.toml", "what is missing, and the command that finds it"},
     {"calibrate all", "calibrate all --arm lab --tracker lab --camera lab --rig my.rig.toml",
      "led step by step"},
     {"calibrate pivot", "calibrate pivot --poses stylus.csv --rig my.rig.toml", "the tip in its marker"},
     {"calibrate arm", "calibrate arm --samples arm.csv --arm phantom-premium-1.5 --rig my.rig.toml",
      "joints, base and tip in one solve"},
     {"calibrate camera", "calibrate camera --images 'left*.jpg' --board 9x6 --square-mm 25", "the lens"},
     {"calibrate hand-eye", "calibrate hand-eye --hand marker.csv --eye board.csv --estimate-delay",
      "the camera in its marker"},
     {"calibrate surface", "calibrate surface --points table.csv --rig my.rig.toml", "a rectangle, touched"},
     {"record", "record --seconds 10 --out devices.mcap", "what the devices say"},
     {"replay", "replay session.mcap", "the same again, and whether it is the same"},
     {"status", "status --once", "what the servers of this machine do"}}};

class HelpPage : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override {
    std::string line;
    if (option->get_type_size() != 0) line = ' ' + takes(*option);
    if (option->get_expected_max() == CLI::detail::expected_max_vector_size)
      line += " ...";
    else if (option->get_expected_min() > 1)
      line += fmt::format(" x {}", option->get_expected());
    if (!option->get_default_str().empty()) line += fmt::format(" ({})", option->get_default_str());
    if (option->get_required()) line += " (required)";
    return line;
  }

  std::string make_option(const CLI::Option* option, bool positional) const override {
    return row(make_option_name(option, positional) + make_option_opts(option), make_option_desc(option));
  }

  std::string make_description(const CLI::App* command) const override {
    return broken(command->get_description(), 0) + '\n';
  }

  std::string make_subcommand(const CLI::App* command) const override {
    return row(command->get_display_name(), command->get_description());
  }

 private:
  // CLI11 tells so which of two names switches off.
  std::string make_option_name(const CLI::Option* option, bool positional) const override {
    return CLI::detail::find_and_replace(CLI::Formatter::make_option_name(option, positional), "{false}", "");
  }

  static std::string takes(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    const auto colon = type.find(':');
    const std::string kind = type.substr(0, colon);
    const std::string expected = colon == std::string::npos ? "" : type.substr(colon + 1);
    if (kind == "FLOAT" || kind == "INT" || kind == "UINT")
      return expected.empty() ? "NUMBER" : "NUMBER " + expected;
    if (kind != "TEXT") return type;
    if (!expected.empty()) return CLI::detail::find_and_replace(expected, ", ", "|");
    for (const auto& name : option.get_lnames())
      for (const Named& known : kTakes)
        if (name == known.name) return std::string(known.takes);
    return "WORD";
  }

  // What stands left, and its words beside it or, where that is too long, below.
  static std::string row(const std::string& left, const std::string& words) {
    const std::string name = "  " + left, column(kWordsAt, ' ');
    const std::string begun = name.size() + 2 > kWordsAt ? name + (words.empty() ? "" : '\n' + column)
                                                         : name + column.substr(name.size());
    return begun + broken(words, kWordsAt) + '\n';
  }

  // Between words, so that a line that begins with `indent` blanks fits.
  static std::string broken(const std::string& words, std::size_t indent) {
    std::istringstream stream(words);
    std::string lines;
    std::size_t at = indent;
    for (std::string word; stream >> word;) {
      const bool first = at == indent;
      if (!first && at + 1 + word.size() > kLineEnds) {
        lines += '\n' + std::string(indent, ' ') + word;
        at = indent + word.size();
        continue;
      }
      lines += (first ? "" : " ") + word;
      at += (first ? 0 : 1) + word.size();
    }
    return lines;
  }
};

void describe(CLI::App& command, const std::string& words, const std::shared_ptr<HelpPage>& page) {
  command.formatter(page);
  const auto* example =
      std::find_if(kExamples.begin(), kExamples.end(), [&](const Example& e) { return e.command == words; });
  if (example != kExamples.end())
    command.footer(fmt::format("Example, {}:\n  palpate {}", example->does, example->line));
  for (auto* below : command.get_subcommands([](const CLI::App*) { return true; }))
    describe(*below, words.empty() ? below->get_name() : words + ' ' + below->get_name(), page);
}

}  // namespace

void describe_help(CLI::App& program) { describe(program, "", std::make_shared<HelpPage>()); }

}  // namespace palpate::tools::commands
