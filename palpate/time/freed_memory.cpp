#include "palpate/time/freed_memory.h"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

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

std::size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  if (!(file >> all >> resident)) return 0;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace palpate::inline time
