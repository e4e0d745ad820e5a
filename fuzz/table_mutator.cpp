#include "fuzz/table_mutator.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "palpate/core/csv.h"
#include "palpate/core/random.h"

namespace palpate::fuzz {
namespace {

using Row = std::vector<std::string>;

std::vector<Row> rows_of(std::string_view file) {
  std::vector<Row> rows;
  while (!file.empty()) {
    const auto end = std::min(file.find('\n'), file.size());
    auto line = file.substr(0, end);
    file.remove_prefix(std::min(end + 1, file.size()));
    auto& row = rows.emplace_back();
    while (true) {
      const auto comma = line.find(',');
      row.emplace_back(line.substr(0, comma));
      if (comma == std::string_view::npos) break;
      line.remove_prefix(comma + 1);
    }
  }
  return rows;
}

std::string text_of(const std::vector<Row>& rows) {
  std::string text;
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) text += (i > 0 ? "," : "") + row[i];
    text += '\n';
  }
  return text;
}

std::string times(const std::string& cell, double factor) {
  return number_text(factor * std::strtod(cell.c_str(), nullptr));
}

class Change {
 public:
  Change(std::vector<Row>& rows, Random& random) : rows_(rows), random_(random) {}

  void make() {
    constexpr std::array kNumbers = {"0",    "-0",     "1",    "-1",    "1e-300", "1e-12", "0.5",
                                     "1e9",  "1e19",   "1e99", "-1e19", "1e308",  "180",   "90",
                                     "1e-5", "0.0001", "",     "nan",   "x",      "360",   "2"};
    constexpr std::array kFactors = {-1.0, 0.0, 1e-9, 1e-3, 0.99, 1.01, 2.0, 1e3, 1e6};
    const std::size_t a = row(), b = row();
    const std::size_t first = random_.below(rows_[a].size()),
                      last = first + 1 + random_.below(rows_[a].size() - first);
    const double factor = kFactors[random_.below(kFactors.size())];
    switch (random_.below(10)) {
      case 0:
        rows_[a][first] = kNumbers[random_.below(kNumbers.size())];
        break;
      case 1:
        rows_.insert(rows_.begin() + static_cast<std::ptrdiff_t>(a), Row(rows_[b]));
        break;
      case 2:
        if (rows_.size() > 2) rows_.erase(rows_.begin() + static_cast<std::ptrdiff_t>(a));
        break;
      case 3:
        rows_[a] = Row(rows_[b]);
        break;
      case 4:
        std::swap(rows_[a], rows_[b]);
        break;
      case 5:
        cells(b, first, last, [&](auto& cell, std::size_t i) { cell = rows_[a][i]; });
        break;
      case 6:
        cells(a, first, last, [&](auto& cell, std::size_t) { cell = times(cell, factor); });
        break;
      case 7:
        column(first, last, [&](auto& cell, std::size_t) { cell = times(cell, factor); });
        break;
      case 8:
        column(first, last, [&](auto& cell, std::size_t i) { cell = rows_[a][i]; });
        break;
      default:
        cells(a, first, last,
              [&](auto& cell, std::size_t) { cell = times(cell, 1.0 + 0.01 * random_.normal()); });
    }
  }

 private:
  std::size_t row() {
    return rows_.size() < 2 ? 0 : 1 + random_.below(rows_.size() - 1);
  }  // seldom the header

  template <typename Edit>
  void cells(std::size_t at, std::size_t first, std::size_t last, Edit edit) {
    for (std::size_t i = first; i < std::min(last, rows_[at].size()); ++i) edit(rows_[at][i], i);
  }
  template <typename Edit>
  void column(std::size_t first, std::size_t last, Edit edit) {
    for (std::size_t r = 1; r < rows_.size(); ++r) cells(r, first, last, edit);
  }

  std::vector<Row>& rows_;
  Random& random_;
};

}  // namespace

bool is_table(std::string_view file) {
  return std::count(file.begin(), file.end(), ',') > 3 && std::count(file.begin(), file.end(), '\n') > 1;
}

std::string changed_table(std::string_view file, std::uint64_t seed) {
  Random random(seed, "fuzz/table");
  auto rows = rows_of(file);
  Change change(rows, random);
  for (std::size_t n = 1 + random.below(3); n > 0; --n) change.make();
  return text_of(rows);
}

}  // namespace palpate::fuzz
