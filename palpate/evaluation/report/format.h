// How a template shows a value: what stands after the bar in {{path | format}}. Pure.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/json.h"

namespace palpate::evaluation::report {

// `format` is one of
//   (nothing)         a text as it is, a number in full, a dash where there is no value
//   3 mm              at most 3 significant digits, and a unit, which may be left out; "%" shows a share in hundredths,
//                     "percent" too, without the sign
//   .1f px, +.1f %    digits in the form of printf, and a unit
//   us                microseconds, or milliseconds from a thousand of them on
//   numbers           a list of numbers, rounded to a ten-thousandth of their span; "numbers log": to 4 digits
//   json              the value as JSON
//   prose             HTML: escaped, with what stands between backticks as code; for {{{...}}}
//   data              of a file's name in `folder`, the file itself as a data: address; empty where there is none
//   > 0, < 1, = 1     for {{#path | > 0}}: whether the number is so ("true" or "")
// Anything else shows as "?".
std::string formatted(const Json& value, std::string_view format, const std::filesystem::path& folder = {});

// JSON of numbers, rounded; not a number is null. `relative`: 4 significant digits each instead.
std::string json_numbers(const std::vector<double>& values, bool relative = false);

}  // namespace palpate::evaluation::report
