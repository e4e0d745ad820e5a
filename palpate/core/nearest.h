// The known word that somebody meant who wrote another: for "did you mean ...?" in messages.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::inline core {

// How many letters have to be put in, taken out or replaced (Levenshtein 1966).
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

// The first of the nearest in `known` that is at most 2 letters, or a third of the word, away, and never more
// than half of it: short words are not like everything. Empty where none is.
template <typename Words>
std::string nearest(std::string_view word, const Words& known) {
  std::string found;
  std::size_t best = std::min(std::max<std::size_t>(2, word.size() / 3), word.size() / 2) + 1;
  for (const std::string_view name : known) {
    // At least so many letters have to be put in or taken out: no long search for what is far too long.
    const std::size_t least = std::max(word.size(), name.size()) - std::min(word.size(), name.size());
    if (least >= best) continue;
    const auto distance = edit_distance(word, name);
    if (distance >= best) continue;
    best = distance;
    found = name;
  }
  return found;
}

}  // namespace palpate::inline core
