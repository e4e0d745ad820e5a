// The kernel's calls that a Video4Linux camera needs, as an interface, so that tests can be a camera.
// Return values and errno are the kernel's. Any thread, one at a time for each descriptor.
#pragma once

#include <cstddef>
#include <cstdint>

namespace palpate::drivers::cameras {

class V4l2Io {
 public:
  virtual ~V4l2Io() = default;
  virtual int open(const char* path) = 0;  // to read and write, without waiting
  virtual void close(int descriptor) = 0;
  virtual int control(int descriptor, unsigned long request, void* argument) = 0;
  virtual void* map(int descriptor, std::size_t length, std::int64_t offset) = 0;  // null where it fails
  virtual void unmap(void* place, std::size_t length) = 0;
  // 1: a frame can be taken; 0: none in time; -1: errno.
  virtual int wait(int descriptor, int milliseconds) = 0;
};

V4l2Io& kernel_v4l2();

}  // namespace palpate::drivers::cameras
