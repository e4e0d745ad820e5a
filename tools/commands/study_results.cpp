#include "tools/commands/study_results.h"

#include <filesystem>

#include "tools/commands/command.h"

namespace palpate::tools::commands {

Expected<void> give_results(std::string_view kind, const evaluation::studies::StudyResult& result,
                            const Json& about, const StudyResults& wanted) {
  if (!wanted.out.empty()) {
    const std::filesystem::path out = wanted.out;
    if (auto done = evaluation::studies::write_study(result, {}, out); !done) return done;
    if (auto done = evaluation::studies::write_study_report(kind, about, {result}, out); !done) return done;
    if (!wanted.quiet) notice(fmt::format("written to {}; open {}/report.html", wanted.out, wanted.out));
  }
  if (!wanted.quiet)
    for (const auto& line : result.lines) print_line(line, lines_beside(wanted.json));
  if (!wanted.json.empty()) return write_json(wanted.json, result.values);
  return {};
}

}  // namespace palpate::tools::commands
