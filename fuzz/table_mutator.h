// Changes tables the way recordings go wrong: rows repeated, lost, swapped or frozen, columns scaled or held
// constant, single numbers huge, tiny, zero or of the wrong sign.
//
// A fuzzer that changes bytes alone hardly ever keeps a quaternion's length or a table's width, so its files
// end in the reader; these reach the solvers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace palpate::fuzz {

// Whether it has the rows and cells to be changed.
bool is_table(std::string_view file);
// A changed copy, the same for the same seed.
std::string changed_table(std::string_view file, std::uint64_t seed);

}  // namespace palpate::fuzz
