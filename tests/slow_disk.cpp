// Loaded in front of a program (LD_PRELOAD): a disk that takes its time. Each write to a recording (*.mcap), and each wait until it is
// on the disk, takes SLOW_DISK_MS, once the file has SLOW_DISK_AFTER bytes; the first SLOW_DISK_CALLS of them.
#include <dlfcn.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <climits>
#include <cstdlib>
#include <string>
#include <string_view>
#include <thread>

namespace {

long number_of(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? 0 : std::atol(text);
}

bool is_slow(int fd) {
  struct stat found {};
  if (::fstat(fd, &found) != 0 || !S_ISREG(found.st_mode) || found.st_size < number_of("SLOW_DISK_AFTER"))
    return false;
  char name[PATH_MAX];
  const ssize_t length = ::readlink(("/proc/self/fd/" + std::to_string(fd)).c_str(), name, sizeof name);
  return length > 0 && std::string_view(name, static_cast<std::size_t>(length)).ends_with(".mcap");
}

void take_time(int fd) {
  static std::atomic<long> calls{0};
  if (is_slow(fd) && calls.fetch_add(1) < number_of("SLOW_DISK_CALLS"))
    std::this_thread::sleep_for(std::chrono::milliseconds(number_of("SLOW_DISK_MS")));
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" ssize_t write(int fd, const void* data, size_t size) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t)>("write");
  take_time(fd);
  return real(fd, data, size);
}

extern "C" int fdatasync(int fd) {
  static const auto real = next<int (*)(int)>("fdatasync");
  take_time(fd);
  return real(fd);
}
