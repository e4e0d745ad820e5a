// Loaded in front of a program (LD_PRELOAD): its clocks, and no other process's, go as a file says, while it runs.
//
// SHIFTED_CLOCK names the file: four 64-bit numbers, ns: what is added to CLOCK_REALTIME, what to CLOCK_MONOTONIC, and, where
// they are not 0, the true monotonic times at which both stop and go on again from where they stood.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>

namespace {

enum { kRealtime, kMonotonic, kStops, kGoesOn, kNumbers };
constexpr std::int64_t kSecond = 1'000'000'000;

// Before anything else of the process asks for the time; none: nobody has named a file.
const volatile std::int64_t* told() {
  static const volatile std::int64_t* const place = []() -> const volatile std::int64_t* {
    const char* path = std::getenv("SHIFTED_CLOCK");
    const int fd = path == nullptr ? -1 : ::open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) return nullptr;
    void* mapped = ::mmap(nullptr, kNumbers * sizeof(std::int64_t), PROT_READ, MAP_SHARED, fd, 0);
    ::close(fd);
    return mapped == MAP_FAILED ? nullptr : static_cast<const volatile std::int64_t*>(mapped);
  }
  ();
  return place;
}

std::int64_t true_time(clockid_t clock) {
  timespec spec{};
  ::syscall(SYS_clock_gettime, clock, &spec);
  return spec.tv_sec * kSecond + spec.tv_nsec;
}

bool is_shifted(clockid_t clock) {
  return told() != nullptr &&
         (clock == CLOCK_REALTIME || clock == CLOCK_MONOTONIC || clock == CLOCK_REALTIME_COARSE ||
          clock == CLOCK_MONOTONIC_RAW || clock == CLOCK_MONOTONIC_COARSE || clock == CLOCK_BOOTTIME);
}

std::int64_t shifted_time(clockid_t clock) {
  std::int64_t time = true_time(clock);
  const std::int64_t stops = told()[kStops], goes_on = told()[kGoesOn];
  if (stops != 0) {
    const std::int64_t now = true_time(CLOCK_MONOTONIC),
                       until = goes_on != 0 && goes_on < now ? goes_on : now;
    if (until > stops) time -= until - stops;
  }
  return time + told()[clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE ? kRealtime : kMonotonic];
}

timespec spec_of(std::int64_t ns) {
  const bool before = ns % kSecond < 0;
  return {ns / kSecond - (before ? 1 : 0), ns % kSecond + (before ? kSecond : 0)};
}

// The true clock's time when the shifted one will show this, if nothing changes.
timespec true_moment(clockid_t clock, const timespec& shown) {
  return spec_of(true_time(clock) + shown.tv_sec * kSecond + shown.tv_nsec - shifted_time(clock));
}

template <typename Function>
Function next_of(Function, const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* spec) noexcept {
  if (!is_shifted(clock)) return static_cast<int>(::syscall(SYS_clock_gettime, clock, spec));
  *spec = spec_of(shifted_time(clock));
  return 0;
}

int gettimeofday(timeval* __restrict time, void* __restrict) noexcept {
  timespec spec{};
  clock_gettime(CLOCK_REALTIME, &spec);
  *time = {spec.tv_sec, spec.tv_nsec / 1000};
  return 0;
}

time_t time(time_t* result) noexcept {
  timespec spec{};
  clock_gettime(CLOCK_REALTIME, &spec);
  if (result != nullptr) *result = spec.tv_sec;
  return spec.tv_sec;
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* until, timespec* left) {
  const bool shifted = is_shifted(clock) && (flags & TIMER_ABSTIME) != 0;
  const timespec moment = shifted ? true_moment(clock, *until) : *until;
  return ::syscall(SYS_clock_nanosleep, clock, flags, &moment, left) == 0 ? 0 : errno;
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const timespec* until) {
  static const auto next = next_of(&pthread_cond_clockwait, "pthread_cond_clockwait");
  const timespec moment = is_shifted(clock) ? true_moment(clock, *until) : *until;
  return next(condition, mutex, clock, &moment);
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex, const timespec* until) {
  static const auto next = next_of(&pthread_cond_timedwait, "pthread_cond_timedwait");
  const timespec moment = is_shifted(CLOCK_REALTIME) ? true_moment(CLOCK_REALTIME, *until) : *until;
  return next(condition, mutex, &moment);
}

}  // extern "C"
