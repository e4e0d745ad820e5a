// Enumerations between memory and wire: a table of pairs says which number means what, so that neither side's order
// matters. Pure. Private to the messages.
#pragma once

#include <optional>

namespace palpate::transport {

template <typename Table, typename Value>
auto to_wire(const Table& table, Value value) {
  for (const auto& [ours, theirs] : table)
    if (ours == value) return theirs;
  return table.front().second;
}

// Nothing for a number that means nothing here.
template <typename Table>
auto from_wire(const Table& table, int value) {
  using Ours = typename Table::value_type::first_type;
  for (const auto& [ours, theirs] : table)
    if (theirs == value) return std::optional<Ours>(ours);
  return std::optional<Ours>();
}

}  // namespace palpate::transport
