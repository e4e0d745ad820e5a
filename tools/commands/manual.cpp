// palpate man, palpate completion: manual pages and completion from the tree of commands itself.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "tools/commands/build_info.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/manual/completion.h"
#include "tools/manual/pages.h"

namespace palpate::tools::commands {
namespace {

struct ManualArguments {
  std::vector<std::string> words;
  std::string out;
};

Expected<void> tell_manual(const CLI::App& program, const ManualArguments& arguments) {
  const auto all = manual::describe(program);
  if (!arguments.out.empty()) {
    std::error_code failed;
    std::filesystem::create_directories(arguments.out, failed);  // what fails here, writing says in words
    return manual::write_manual_pages(all, build_info().version, arguments.out);
  }
  const auto* command = manual::find(all, arguments.words);
  if (command == nullptr)
    return wrong_use("'{}': no such command; `palpate --help` lists them",
                     excerpt(manual::joined(arguments.words, " ")));
  fmt::print("{}", manual::manual_page(*command, build_info().version));
  return {};
}

}  // namespace

void add_manual(CLI::App& program) {
  auto* completion =
      program.add_subcommand("completion",
                             "A script that lets a shell complete palpate's commands and options: "
                             "source <(palpate completion bash)");
  auto shell = std::make_shared<std::string>();
  completion->add_option("SHELL", *shell, "Which shell reads it")->required()->check(one_of({"bash"}));
  on(completion, [&program, shell]() -> Expected<void> {
    fmt::print("{}", manual::bash_completion(manual::describe(program)));
    return {};
  });
  auto arguments = std::make_shared<ManualArguments>();
  // For who installs: a person types `man palpate-calibrate-pivot`.
  auto* man =
      program
          .add_subcommand("man",
                          "Manual page of a command, as man reads it: palpate man calibrate pivot | man -l -")
          ->group("");
  man->add_option("COMMAND", arguments->words, "Words of the command; none: the program's own page");
  man->add_option("--out", arguments->out, "Write the pages of all commands into this folder")
      ->type_name("DIR");
  on(man, [&program, arguments] { return tell_manual(program, *arguments); });
}

}  // namespace palpate::tools::commands
