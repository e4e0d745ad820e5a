#include "palpate/core/file_descriptor.h"

#include <fcntl.h>
#include <gtest/gtest.h>

namespace palpate::inline core {
namespace {

bool open(int fd) { return ::fcntl(fd, F_GETFD) >= 0; }

TEST(FileDescriptor, IsClosedByItsLastOwnerAndLeavesErrnoAlone) {
  const int fd = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  ASSERT_GE(fd, 0);
  FileDescriptor kept;
  EXPECT_FALSE(kept);
  {
    FileDescriptor first(fd);
    EXPECT_TRUE(first);
    kept = std::move(first);
  }
  EXPECT_TRUE(open(fd));
  FileDescriptor& same = kept;
  kept = std::move(same);
  EXPECT_EQ(kept.get(), fd);
  {
    const FileDescriptor last = std::move(kept);
    errno = ENOSPC;
  }
  EXPECT_EQ(errno, ENOSPC);
  EXPECT_FALSE(open(fd));
}

TEST(FileDescriptor, WhatIsTakenOverAnotherClosesThatOne) {
  FileDescriptor one(::open("/dev/null", O_RDONLY | O_CLOEXEC)), other(::dup(one.get()));
  const int before = one.get(), after = other.get();
  one = std::move(other);
  EXPECT_FALSE(open(before));
  EXPECT_TRUE(open(after));
  const int released = one.release();
  EXPECT_FALSE(one);
  EXPECT_TRUE(open(released));
  ::close(released);
}

}  // namespace
}  // namespace palpate::inline core
