// A file of a page's presentation, as it travels inside a program: a template, a style, words and limits. Values.
#pragma once

#include <string_view>
#include <vector>

namespace palpate::figures {

struct PageFile {
  std::string_view name;  // "demo.html"
  std::string_view text;  // its bytes, valid as long as the program runs
};
using PageFiles = std::vector<PageFile>;

}  // namespace palpate::figures
