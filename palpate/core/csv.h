// Comma-separated tables of numbers, read strictly: every complaint names file, line and column.
//
// Lines starting with '#' and blank lines are skipped. A first line in which any cell is not a number is the
// header. Cells of columns named in `text_columns` may be names: at most 120 bytes, no control characters.
// A column nobody asks for may hold anything (the frame's name in a log, a tracker's state): a cell that is no
// number is a complaint where its column is asked for by require(), require_numbers() or require_within().
// NaN and infinity are no numbers: no device of ours reports them, and they poison every least-squares sum.
// Refused are tables that would take more memory and time than a table of measurements is worth, and files
// that are no tables with commas at all (file_form.h).
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::inline core {

inline constexpr std::size_t kMostTableRows = 4'000'000;  // an hour of a kilohertz
inline constexpr std::size_t kMostTableColumns = 10'000;
inline constexpr std::size_t kMostTableCells = 40'000'000;  // 56 bytes of memory each

struct CsvTable {
  std::string source;                          // for messages: the file's name
  std::vector<std::string> header;             // empty where the file has none
  std::vector<std::vector<double>> rows;       // numbers; what is no finite number reads as NaN here
  std::vector<std::vector<std::string>> text;  // the same cells as written, trimmed
  std::vector<int> line;                       // line number of each row
  // Of each column that may hold no text: the first row whose cell is no finite number.
  std::vector<std::optional<std::size_t>> no_number;

  std::size_t columns() const {
    return header.empty() ? (rows.empty() ? 0 : rows.front().size()) : header.size();
  }
  // The column of this name; where there is none, one that is written in other letters (Time_s).
  std::optional<std::size_t> find(std::string_view column) const;
  bool has(std::string_view column) const { return find(column).has_value(); }
  // The column's position; wrong use naming the columns there are, or a cell that is no number.
  Expected<std::size_t> require(std::string_view column) const;
  // Wrong use with line and column where a cell of these columns is no finite number. Who has a position from
  // find() asks this before it reads numbers there; columns that may be text pass.
  Expected<void> require_numbers(const std::vector<std::size_t>& at) const;
  // The same, and where a number is larger than `limit`, either sign: finite, but its square may not be, and
  // no device reports it.
  Expected<void> require_within(const std::vector<std::size_t>& at, double limit) const;
  // Takes out the rows in which none of these columns holds a finite number; how many there were.
  std::size_t leave_out_rows_without(const std::vector<std::size_t>& at);
};

struct CsvOptions {
  // Names of columns whose cells may be text (labels, image names); every column is tried when "*".
  std::vector<std::string> text_columns = {"label", "name", "image", "phase", "status"};
};

Expected<CsvTable> parse_csv(std::string_view content, std::string source, const CsvOptions& options = {});
Expected<CsvTable> read_csv(const std::filesystem::path& path, const CsvOptions& options = {});

// Builds a CSV text. Numbers are written with up to 10 significant digits unless the column asks for more.
class CsvWriter {
 public:
  explicit CsvWriter(std::vector<std::string> header);
  void row(const std::vector<double>& values);
  void row(const std::vector<std::string>& cells);
  const std::string& content() const { return content_; }

 private:
  std::size_t columns_;
  std::string content_;
};

// A number as CSV and JSON readers expect it, shortest form that keeps 12 significant digits.
std::string number_text(double value);

}  // namespace palpate::inline core
