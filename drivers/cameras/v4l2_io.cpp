#include "drivers/cameras/v4l2_io.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

namespace palpate::drivers::cameras {
namespace {

class Kernel : public V4l2Io {
 public:
  int open(const char* path) override { return ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC); }
  void close(int descriptor) override { ::close(descriptor); }
  int control(int descriptor, unsigned long request, void* argument) override {
    int result = 0;
    do {
      result = ::ioctl(descriptor, request, argument);
    } while (result == -1 && errno == EINTR);
    return result;
  }
  void* map(int descriptor, std::size_t length, std::int64_t offset) override {
    void* place = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, offset);
    return place == MAP_FAILED ? nullptr : place;
  }
  void unmap(void* place, std::size_t length) override { ::munmap(place, length); }
  int wait(int descriptor, int milliseconds) override {
    pollfd item{descriptor, POLLIN, 0};
    const int ready = ::poll(&item, 1, milliseconds);
    if (ready < 0) return errno == EINTR ? 0 : -1;
    // An unplugged camera is always ready, with an error: the next call says which.
    return ready > 0 ? 1 : 0;
  }
};

}  // namespace

V4l2Io& kernel_v4l2() {
  static Kernel kernel;
  return kernel;
}

}  // namespace palpate::drivers::cameras
