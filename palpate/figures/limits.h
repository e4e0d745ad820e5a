// The limits that figures are judged by, as data: a TOML file with a table for each judgement.
//
//   [returned]
//   figure = "rally/returned"     # where its value stands in the figures; required
//   label = "Serves returned"     # what it is, in words; else the path stands for it
//   unit = ""                     # of value and limit, for who shows them
//   of = "rally/serves"           # judged is its share of this figure
//   of_at_least = 20              # with less of that there is no verdict
//   at_least = 0.6                # the limit; or at_most
//   least_of = ["a/b_mm", "c_mm"] # with at_most, or alone: also the least of these figures ...
//   share = 0.5                   # ... so large a part of it (1); no limit where none of them is known
//   needed_by = "network"         # where this is known and the figure is not, it falls short
#pragma once

#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"

namespace palpate::figures {

// Of each judgement whose figure is known, under its name: {"figure", "unit", "label", "value", "limit", "verdict"}, verdict
// "holds" or "falls short"; limit and verdict null where there are none; with a limit "bound", "at most" or "at least". `figures` is nested JSON, of which "a/b" is
// a path. Pure. Errors: wrong use for a file that is none, naming `source` and the key.
Expected<Json> judged(const Json& figures, std::string_view limits_toml, std::string source);

// The value at a path ("arm/error_mm"); null where there is none.
const Json* find_in(const Json& figures, std::string_view path);

}  // namespace palpate::figures
