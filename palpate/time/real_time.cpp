#include "palpate/time/real_time.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <link.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <utility>

namespace palpate::inline time {
namespace {

[[gnu::noinline]] void touch_stack() {
  std::array<char, 64 * 1024> stack;
  for (std::size_t i = 0; i < stack.size(); i += 1024) *static_cast<volatile char*>(&stack[i]) = 0;
}

// The code of the program and its libraries, so that no loop waits for a page of it that runs for the first time
// in the hour in which a force has to be taken back. Once; a kernel before 5.14 cannot.
void touch_code() {
  static const int touched = dl_iterate_phdr(
      [](dl_phdr_info* object, std::size_t, void*) {
        const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
        for (int i = 0; i < object->dlpi_phnum; ++i) {
          const ElfW(Phdr)& part = object->dlpi_phdr[i];
          if (part.p_type != PT_LOAD || (part.p_flags & PF_W) != 0) continue;
          const std::uintptr_t first = (object->dlpi_addr + part.p_vaddr) / page * page,
                               end = object->dlpi_addr + part.p_vaddr + part.p_memsz;
          madvise(reinterpret_cast<void*>(first), end - first, MADV_POPULATE_READ);
        }
        return 0;
      },
      nullptr);
  static_cast<void>(touched);
}

}  // namespace

CoresAwake::CoresAwake() {
  FileDescriptor file(open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC));
  const std::int32_t most_us = 0;
  if (file && write(file.get(), &most_us, sizeof most_us) == sizeof most_us) file_ = std::move(file);
}

void sharpen_sleep() { prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL); }

void ask_for_short_turns() {
  if (sched_getscheduler(0) != SCHED_OTHER) return;
  struct {  // sched_attr of <linux/sched/types.h>, whose other names collide with <sched.h>
    std::uint32_t size = 48, policy = SCHED_OTHER;
    std::uint64_t flags = 0;
    std::int32_t nice = 0;
    std::uint32_t priority = 0;
    std::uint64_t runtime = 100'000, deadline = 0, period = 0;  // ns
  } attributes;
  attributes.nice = getpriority(PRIO_PROCESS, 0);
  syscall(SYS_sched_setattr, 0, &attributes, 0);  // refused where unknown: then it stays as it was
}

void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
}

void name_and_pin_thread(const char* name, int cpu) {
  std::array<char, 16> shortened{};
  std::strncpy(shortened.data(), name, shortened.size() - 1);
  pthread_setname_np(pthread_self(), shortened.data());
  if (cpu < 0) return;
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

RealTimeGrant enter_real_time(int priority) {
  RealTimeGrant grant;
  sharpen_sleep();
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) {
    grant.memory_locked = true;
  } else {
    grant.memory_errno = errno;
  }
  touch_stack();
  touch_code();
  sched_param parameters{};
  parameters.sched_priority = priority;
  grant.fifo_errno = pthread_setschedparam(pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters);
  if (grant.fifo_errno == 0) grant.fifo_priority = priority;
  return grant;
}

std::string RealTimeGrant::describe() const {
  std::string text;
  if (fifo()) {
    text = fmt::format("SCHED_FIFO priority {}", fifo_priority);
  } else if (fifo_errno == 0) {
    text = "ordinary scheduling, as asked";
  } else {
    text =
        fmt::format("ordinary scheduling: SCHED_FIFO refused ({}), an rtprio entry in limits.conf allows it",
                    std::strerror(fifo_errno));
  }
  if (memory_locked) {
    text += "; memory locked";
  } else if (memory_errno != 0) {
    text += fmt::format("; memory not locked ({}), a memlock entry in limits.conf allows it",
                        std::strerror(memory_errno));
  }
  return text;
}

}  // namespace palpate::inline time
