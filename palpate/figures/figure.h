// A key figure of a page, and whether it holds against its bar. Values; nothing here knows HTML.
#pragma once

#include <string>

namespace palpate::figures {

enum class Verdict { none, holds, falls_short };

struct Figure {
  std::string label;
  std::string value;  // with its unit
  std::string bar;    // what it is held against; may be empty
  Verdict verdict = Verdict::none;
};

// `figure <= bar` or not, as a verdict.
inline Verdict at_most(double figure, double bar) {
  return figure <= bar ? Verdict::holds : Verdict::falls_short;
}

}  // namespace palpate::figures
