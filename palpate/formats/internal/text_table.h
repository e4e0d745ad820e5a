// A text of cells as others write them: separated by commas, semicolons, tabs or blanks, quoted or not, with decimal commas.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::formats {

struct Separation {
  char separator = ',';  // ' ': any run of blanks and tabs
  bool decimal_commas = false;
};

// Which separates the cells of these lines; judged by the first twenty.
Separation separation_of(std::string_view content);

// The cells of one line, without quotes and outer blanks; commas within quotes do not separate. At most `most` of them.
std::vector<std::string_view> cells_of(std::string_view line, char separator, std::size_t most);

// A finite number; nothing where the cell is none.
std::optional<double> number_of(std::string_view cell, bool decimal_commas = false);

// Takes the next line off the content's front, without its end; nothing where there is none.
std::optional<std::string_view> next_line(std::string_view& content);
std::string_view trimmed(std::string_view text);

// What stands in a cell where there is no value: nothing, nan, NA, null.
bool is_missing(std::string_view cell);

// Rows of numbers without a header. Lines that begin with '#' or '%', and empty ones, are passed over; a missing value is NaN.
struct NumberRows {
  std::vector<std::vector<double>> rows;
  std::vector<int> line;
};
// Wrong use where a cell is no number.
Expected<NumberRows> number_rows(std::string_view content, const std::string& source);

}  // namespace palpate::formats
