// What a command line takes, as values, read from the parser's own tree: nothing is told twice, and nothing that the
// parser knows is left out. Hidden commands and options, which have no group, are.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace palpate::tools::manual {

enum class Value { none, file, folder, word, other };  // `word`: one of the choices

struct Option {
  std::vector<std::string> names;  // "-h", "--help"; of an argument without a dash its name alone
  Value value = Value::none;
  std::string type;                  // of the value: "FILE", "0.1 to 60"
  std::vector<std::string> choices;  // where it is one of some words
  std::string standard;  // taken where nobody says otherwise; empty: nothing, or nothing to be told
  std::string text;
  bool required = false;
};

struct Command {
  std::vector<std::string> words;  // "palpate", "calibrate", "pivot"
  std::string text;
  std::vector<Option> options, arguments;
  std::vector<Command> commands;
};

Command describe(const CLI::App& program);

// The same command by the words behind the program's name; null where there is none.
const Command* find(const Command& program, const std::vector<std::string>& words);

std::string joined(const std::vector<std::string>& words, const char* between);

}  // namespace palpate::tools::manual
