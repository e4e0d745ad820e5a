#pragma once
// Counts what a test program takes from the heap and gives back. Link palpate_allocation_count (TEST_LIBRARIES): its
// operator new and delete replace the usual ones of the whole test program. Any thread.

#include <cstddef>

namespace palpate {

std::size_t allocations();  // so far, by all threads
std::size_t held_bytes();   // taken and not given back, by all threads

}  // namespace palpate
