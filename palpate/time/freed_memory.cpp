#include "palpate/time/freed_memory.h"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>

namespace palpate::inline time {
namespace {

bool memory_is_locked() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    long kib = 0;
    if (word == "VmLck:") return status >> kib && kib > 0;
  }
  return false;
}

}  // namespace

void give_back_freed_memory() {
  const bool locked = memory_is_locked();
  if (locked) munlockall();
  malloc_trim(0);
  if (locked) mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT);
}

FreedMemory::FreedMemory(std::size_t kept, std::size_t resident, std::size_t freed)
    : kept_(kept), least_resident_(resident), least_freed_(freed) {}

bool FreedMemory::has_grown(std::size_t resident, std::size_t freed) {
  least_resident_ = std::min(least_resident_, resident);
  least_freed_ = std::min(least_freed_, freed);
  return freed >= kept_ && (resident >= least_resident_ + kept_ || freed >= least_freed_ + kept_);
}

void FreedMemory::was_given_back(std::size_t resident, std::size_t freed) {
  least_resident_ = resident;
  least_freed_ = freed;
}

std::size_t freed_bytes() { return mallinfo2().fordblks; }

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  if (!(file >> all >> resident)) return 0;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace palpate::inline time
