// What the commands do with the result of a study of a file.
#pragma once

#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/evaluation/studies/study.h"

namespace palpate::tools::commands {

struct StudyResults {
  std::string out, json;  // --out and --json; empty: not asked for
  bool quiet = false;     // no lines for the person
};

// Files and page of --out, lines for the person, figures for --json. `kind` names the page's template; `about`, what was studied.
Expected<void> give_results(std::string_view kind, const evaluation::studies::StudyResult& result,
                            const Json& about, const StudyResults& wanted);

}  // namespace palpate::tools::commands
