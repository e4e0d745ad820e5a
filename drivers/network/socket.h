// TCP sockets, set up as those of all drivers are.
#pragma once

#include <utility>
#include <vector>

#include <netinet/in.h>
#include <sys/socket.h>

#include "drivers/network/address.h"
#include "palpate/core/file_descriptor.h"

namespace palpate::drivers::network {

// An eventfd: set() from any thread ends another's poll().
class Wake {
 public:
  static Expected<Wake> make();
  void set();
  void clear();
  int fd() const { return fd_.get(); }

 private:
  explicit Wake(FileDescriptor fd) : fd_(std::move(fd)) {}
  FileDescriptor fd_;
};

struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t size = 0;
};

// Asks the system's resolver, which for a name (not a number) may take its time.
Expected<std::vector<SocketAddress>> resolve(const Address& address);

// Begins to connect; poll for writing, then connected() tells. No descriptor where that fails at once.
FileDescriptor begin_connect(const SocketAddress& to);
bool connected(const FileDescriptor& socket);

struct Listening {
  FileDescriptor socket;
  Address address;  // with the port that the system chose
};
Expected<Listening> listen_at(const Address& address);
// The next client that waits. No descriptor: none, or (then errno says so) no more descriptors.
FileDescriptor accept_from(const FileDescriptor& listening);

}  // namespace palpate::drivers::network
