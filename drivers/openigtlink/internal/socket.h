// Descriptors and TCP sockets, set up as this module's all are. Private to it.
#pragma once

#include <utility>
#include <vector>

#include <netinet/in.h>
#include <sys/socket.h>

#include "drivers/openigtlink/address.h"

namespace palpate::drivers::openigtlink {

class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    if (this != &other) {
      close();
      fd_ = std::exchange(other.fd_, -1);
    }
    return *this;
  }
  ~Descriptor() { close(); }
  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }

 private:
  void close();
  int fd_;
};

// An eventfd: set() from any thread ends another's poll().
class Wake {
 public:
  static Expected<Wake> make();
  void set();
  void clear();
  int fd() const { return fd_.get(); }

 private:
  explicit Wake(Descriptor fd) : fd_(std::move(fd)) {}
  Descriptor fd_;
};

struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t size = 0;
};

// Asks the system's resolver, which for a name (not a number) may take its time.
Expected<std::vector<SocketAddress>> resolve(const Address& address);

// Begins to connect; poll for writing, then connected() tells. No descriptor where that fails at once.
Descriptor begin_connect(const SocketAddress& to);
bool connected(const Descriptor& socket);

struct Listening {
  Descriptor socket;
  Address address;  // with the port that the system chose
};
Expected<Listening> listen_at(const Address& address);
// The next client that waits. No descriptor: none, or (then errno says so) no more descriptors.
Descriptor accept_from(const Descriptor& listening);

}  // namespace palpate::drivers::openigtlink
