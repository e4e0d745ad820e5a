// A part of a page: a title and what stands under it, in this order. Values; who draws pages knows how each
// looks (palpate/evaluation/report).
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "palpate/figures/figure.h"
#include "palpate/figures/plot.h"

namespace palpate::figures {

struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  // each as long as the header
};

struct Section {
  // A paragraph, key figures, plots side by side, or a table.
  using Block = std::variant<std::string, std::vector<Figure>, std::vector<Plot>, Table>;

  std::string title;
  std::string anchor;  // its address in the page: letters, digits, hyphens
  std::vector<Block> blocks;
};

}  // namespace palpate::figures
