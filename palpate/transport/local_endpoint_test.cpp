#include "palpate/transport/local_endpoint.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "palpate/core/file.h"
#include "tests/own_run_directory.h"

namespace palpate::transport {
namespace {

int bound_socket(const std::filesystem::path& path) {
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  EXPECT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  return fd;
}

TEST(LocalEndpoint, TheDefaultLiesInAFolderOnlyTheUserCanEnter) {
  ScratchFolder scratch;
  OwnRunDirectory runtime(scratch.path());
  const auto endpoint = default_endpoint();
  ASSERT_TRUE(endpoint) << endpoint.error().message;
  EXPECT_EQ(endpoint->address, "ipc://" + scratch.path().string() + "/palpate/physics.sock");
  struct stat info {};
  ASSERT_EQ(stat(endpoint->socket.parent_path().c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777, 0700u);
  EXPECT_TRUE(default_endpoint());  // and again, now that the folder is there
}

TEST(LocalEndpoint, AFolderOpenToOthersIsRefused) {
  ScratchFolder scratch;
  OwnRunDirectory runtime(scratch.path());
  const auto folder = scratch.path() / "palpate";
  std::filesystem::create_directory(folder);
  chmod(folder.c_str(), 0755);
  const auto open = default_endpoint();
  ASSERT_FALSE(open);
  EXPECT_NE(open.error().message.find("chmod 700"), std::string::npos) << open.error().message;
}

TEST(LocalEndpoint, TcpIsEncryptedUnlessAskedForAsInsecure) {
  const auto usual = parse_endpoint("tcp://127.0.0.1:5555", EndpointUse::listen);
  ASSERT_TRUE(usual);
  EXPECT_TRUE(usual->encrypted);
  const auto open = parse_endpoint("tcp://localhost:5555", EndpointUse::listen, true);
  ASSERT_TRUE(open);
  EXPECT_FALSE(open->encrypted);
  EXPECT_EQ(open->address, "tcp://127.0.0.1:5555");
  EXPECT_FALSE(open->local());
}

TEST(LocalEndpoint, AddressesThatMeanNothingAreWrongUse) {
  for (const char* text : {"", "physics", "udp://host:1", "tcp://", "tcp://host", "tcp://:5",
                           "tcp://host:", "tcp://host:x", "tcp://host:65536", "tcp://host:-1", "tcp://a;b:5",
                           "ipc://", "ipc://@abstract", "ipc://*", "ipc:///no/such/folder/x.sock"}) {
    const auto endpoint = parse_endpoint(text, EndpointUse::connect, false);
    ASSERT_FALSE(endpoint) << text;
    EXPECT_EQ(endpoint.error().kind, Error::Kind::wrong_use) << text;
  }
  EXPECT_FALSE(parse_endpoint("tcp://host:0", EndpointUse::connect, true));
  EXPECT_FALSE(parse_endpoint("tcp://two\nlines:5555", EndpointUse::connect, true));
  EXPECT_FALSE(parse_endpoint("tcp://*:5555", EndpointUse::connect, true));
  EXPECT_TRUE(parse_endpoint("tcp://127.0.0.1:*", EndpointUse::listen, true));
}

TEST(LocalEndpoint, ASocketPathLongerThanTheSystemTakesIsRefused) {
  ScratchFolder scratch;
  const std::string folder = scratch.path().string() + "/";
  const std::string longest = folder + std::string(107 - folder.size(), 's');
  EXPECT_TRUE(parse_endpoint("ipc://" + longest, EndpointUse::listen));
  const auto refusal = parse_endpoint("ipc://" + longest + "s", EndpointUse::listen);
  ASSERT_FALSE(refusal);
  EXPECT_NE(refusal.error().message.find("108 bytes"), std::string::npos) << refusal.error().message;
}

TEST(LocalEndpoint, ASocketWhereOthersCanWriteNeedsTheInsecureFlag) {
  const auto refusal = parse_endpoint("ipc:///tmp/palpate-test.sock", EndpointUse::connect);
  ASSERT_FALSE(refusal);
  EXPECT_EQ(refusal.error().kind, Error::Kind::wrong_use);
  EXPECT_TRUE(parse_endpoint("ipc:///tmp/palpate-test.sock", EndpointUse::connect, true));
}

TEST(SocketClaim, IsHeldByOneAndFreeAgainAfterwards) {
  ScratchFolder scratch;
  const auto path = scratch.path() / "x.sock";
  {
    const auto first = SocketClaim::take(path);
    ASSERT_TRUE(first) << first.error().message;
    const auto second = SocketClaim::take(path);
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().message.find(fmt::format("address in use by process {}", getpid())),
              std::string::npos)
        << second.error().message;
  }
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path()));
  EXPECT_TRUE(SocketClaim::take(path));
}

TEST(SocketClaim, ADeadServersSocketIsRemoved) {
  ScratchFolder scratch;
  const auto path = scratch.path() / "x.sock";
  ::close(bound_socket(path));  // as after kill -9: the file stays
  ASSERT_TRUE(std::filesystem::is_socket(path));
  EXPECT_TRUE(SocketClaim::take(path));
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(SocketClaim, ALivingStrangersSocketAndAFileStayUntouched) {
  ScratchFolder scratch;
  const auto path = scratch.path() / "x.sock";
  const int fd = bound_socket(path);
  ASSERT_EQ(::listen(fd, 1), 0);
  EXPECT_FALSE(SocketClaim::take(path));
  EXPECT_TRUE(std::filesystem::is_socket(path));
  ::close(fd);

  const auto file = scratch.path() / "file";
  ASSERT_TRUE(write_file(file, "precious"));
  EXPECT_FALSE(SocketClaim::take(file));
  EXPECT_EQ(*read_file(file), "precious");
}

}  // namespace
}  // namespace palpate::transport
