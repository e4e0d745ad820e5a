#include "fuzz/check.h"

#include <cstdio>
#include <cstdlib>

#include "palpate/core/text.h"

namespace palpate::fuzz {

void hold(bool promise, std::string_view what) {
  if (promise) return;
  std::fprintf(stderr, "broken promise: %.*s\n", static_cast<int>(what.size()), what.data());
  std::abort();
}

void hold_one_line(const Error& error) {
  constexpr std::size_t kLongest = 600;
  const auto& text = error.message;
  const bool fine = !text.empty() && text.size() <= kLongest && !has_control(text);
  if (!fine) std::fprintf(stderr, "the error is '%s'\n", text.c_str());
  hold(fine, "an error is one line without control characters, of at most 600 bytes");
}

}  // namespace palpate::fuzz
