#pragma once
// Counts what a test program takes from the heap. Link palpate_allocation_count (TEST_LIBRARIES): its
// operator new and delete replace the usual ones of the whole test program. Any thread.

#include <cstddef>

namespace palpate {

std::size_t allocations();  // so far, by all threads

}  // namespace palpate
