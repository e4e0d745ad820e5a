#include "tools/manual/completion.h"

#include <fmt/format.h>

namespace palpate::tools::manual {
namespace {

// What the script looks up, as patterns and bodies of its `case`s. A command is a path: "/calibrate/pivot".
struct Cases {
  std::vector<std::string> paths, files, folders, others;  // patterns
  std::string choices, words;                              // whole lines
};

std::string path_of(const Command& command) {
  std::string path;
  for (std::size_t i = 1; i < command.words.size(); ++i) path += '/' + command.words[i];
  return path;
}

void gather(const Command& command, Cases& cases) {
  const std::string path = path_of(command);
  const bool whole_program = path.empty();
  if (!whole_program) cases.paths.push_back(path);
  std::vector<std::string> options, below;
  for (const auto& option : command.options) {
    for (const auto& name : option.names) {
      options.push_back(name);
      // The program's own options may stand behind any command.
      const auto pattern = (whole_program ? "*" : path) + ':' + name;
      if (option.value == Value::file) cases.files.push_back(pattern);
      if (option.value == Value::folder) cases.folders.push_back(pattern);
      if (option.value == Value::other) cases.others.push_back(pattern);
      if (option.value == Value::word)
        cases.choices +=
            fmt::format("    {}) _palpate_offer '{}'; return ;;\n", pattern, joined(option.choices, " "));
    }
  }
  bool takes_files = false;
  for (const auto& argument : command.arguments) {
    below.insert(below.end(), argument.choices.begin(), argument.choices.end());
    takes_files = takes_files || argument.value == Value::file || argument.value == Value::folder;
  }
  for (const auto& one : command.commands) below.push_back(one.words.back());
  cases.words += fmt::format("    {}) options='{}' words='{}' files={} ;;\n", whole_program ? "''" : path,
                             joined(options, " "), joined(below, " "), takes_files ? "yes" : "");
  for (const auto& one : command.commands) gather(one, cases);
}

std::string one_case(const std::vector<std::string>& patterns, const char* body) {
  return patterns.empty() ? "" : fmt::format("    {}) {} ;;\n", joined(patterns, " | "), body);
}

constexpr const char* kScript =
    R"(# Completion of {program} in bash, as `{program} completion bash` writes it.

_palpate_offer() {{
  mapfile -t COMPREPLY < <(compgen -W "$1" -- "$current")
}}

_palpate_names() {{ # -f or -d
  compopt -o filenames
  mapfile -t COMPREPLY < <(compgen "$1" -- "$current")
}}

_palpate() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} option=${{COMP_WORDS[COMP_CWORD - 1]}} command='' options='' words='' files='' i
  # bash takes the '=' of --option=value for a word of its own.
  if [[ $current == '=' ]]; then
    current=''
  elif [[ $option == '=' ]]; then
    option=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for ((i = 1; i < COMP_CWORD; i++)); do
    case $command/${{COMP_WORDS[i]}} in
{paths}    esac
  done
  case $command:$option in
{values}  esac
  case $command in
{words}  esac
  if [[ $current == -* || (-z $words && -z $files) ]]; then
    _palpate_offer "$options"
  elif [[ -n $words ]]; then
    _palpate_offer "$words"
  fi
  [[ $current == -* || -z $files || ${{#COMPREPLY[@]}} -gt 0 ]] || _palpate_names -f
}}

complete -F _palpate {program}
)";

}  // namespace

std::string bash_completion(const Command& program) {
  Cases cases;
  gather(program, cases);
  const auto paths = one_case(cases.paths, "command+=/${COMP_WORDS[i]}");
  const auto values = one_case(cases.files, "_palpate_names -f; return") +
                      one_case(cases.folders, "_palpate_names -d; return") +
                      one_case(cases.others, "return") + cases.choices;
  return fmt::format(kScript, fmt::arg("program", program.words.front()), fmt::arg("paths", paths),
                     fmt::arg("values", values), fmt::arg("words", cases.words));
}

}  // namespace palpate::tools::manual
