// An open file, socket or event that is closed at the end of its owner's life. Moved, not copied; errno is as before
// after the closing, so that what has failed can still be told. One thread.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <utility>

namespace palpate::inline core {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd = -1) : fd_(fd) {}  // below 0: none
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(other.release()) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    if (this != &other) {
      close();
      fd_ = other.release();
    }
    return *this;
  }
  ~FileDescriptor() { close(); }

  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }
  int release() { return std::exchange(fd_, -1); }
  void close() {
    if (fd_ < 0) return;
    const int error = errno;
    ::close(release());
    errno = error;
  }

 private:
  int fd_;
};

}  // namespace palpate::inline core
