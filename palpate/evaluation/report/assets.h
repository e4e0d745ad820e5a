// Files that travel inside the program, so that an installed Palpate needs no source tree to write a report.
#pragma once

#include <string_view>

namespace palpate::evaluation::report {

std::string_view plotly_js();  // third_party/plotly, unchanged
std::string_view page_css();
std::string_view page_js();

}  // namespace palpate::evaluation::report
