#include "tests/allocation_count.h"

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

// In a file of its own: where a compiler sees through these two into malloc and free, it takes the matched
// pair for a mistake.

namespace {
std::atomic<std::size_t> count = 0, held = 0;
}

std::size_t palpate::allocations() { return count; }
std::size_t palpate::held_bytes() { return held; }

// Every form is replaced, so that each delete meets memory of its own new.

namespace {
void* take(std::size_t size, std::size_t alignment = alignof(std::max_align_t)) noexcept {
  ++count;
  void* p = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  held += ::malloc_usable_size(p);
  return p;
}
void give_back(void* p) noexcept {
  held -= ::malloc_usable_size(p);
  std::free(p);
}
void* given(void* p) {
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
}  // namespace

void* operator new(std::size_t size) { return given(take(size)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return take(size); }
void* operator new(std::size_t size, std::align_val_t to) {
  return given(take(size, static_cast<std::size_t>(to)));
}
void operator delete(void* p) noexcept { give_back(p); }
void operator delete(void* p, std::size_t) noexcept { give_back(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { give_back(p); }
void operator delete(void* p, std::align_val_t) noexcept { give_back(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { give_back(p); }
