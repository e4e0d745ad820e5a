// Where servers meet on this machine: endpoint names, the private folder for unix sockets, and who owns an
// address.
//
// A unix socket lies in a folder that only its user can enter, so nobody else can listen in, answer in the
// server's place, or send commands. tcp:// has no such protection: it is encrypted and both sides need keys
// (keys.h), unless it is asked for as insecure.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/core/file_descriptor.h"

namespace palpate::transport {

struct Endpoint {
  std::string address;           // as ZeroMQ takes it
  std::filesystem::path socket;  // of ipc://, else empty

  bool encrypted = false;  // tcp:// that was not asked for as insecure

  bool local() const { return !socket.empty(); }
};

enum class EndpointUse { listen, connect };

// ipc://<run_directory()>/<name>.sock
Expected<Endpoint> default_endpoint(std::string_view name = "physics");

// ipc://PATH or tcp://HOST:PORT. Wrong use: any other form, a path too long for a unix socket, an ipc folder
// that others can write to without `insecure`. Port 0 lets the system choose and is for
// listening only.
Expected<Endpoint> parse_endpoint(std::string_view text, EndpointUse use, bool insecure = false);

// Where a server at `service` publishes its states: ipc://PATH.states, tcp://HOST:(PORT + 1); port 0 stays
// the system's choice. Wrong use: a path that becomes too long, port 65535.
Expected<Endpoint> states_endpoint(const Endpoint& service);

// Whether somebody accepts connections at this socket; a dead server's socket accepts none. Disturbs nobody.
bool somebody_listens(const std::filesystem::path& socket);

// The right to listen at a socket path, held as a lock on the file <path>.lock for the life of this object;
// the socket goes with it. ZeroMQ takes over a path that another process listens at without a word; this is
// what prevents it.
class SocketClaim {
 public:
  // Refused while another server lives there; removes the socket a dead one has left. Never touches a file
  // that is not a socket.
  static Expected<SocketClaim> take(const std::filesystem::path& socket);
  SocketClaim(SocketClaim&& other) noexcept;
  SocketClaim& operator=(SocketClaim&& other) noexcept;
  ~SocketClaim();

 private:
  SocketClaim(FileDescriptor lock, std::filesystem::path socket)
      : lock_(std::move(lock)), socket_(std::move(socket)) {}
  void release();

  FileDescriptor lock_;
  std::filesystem::path socket_;
  bool ours_ = false;  // whatever socket lies there now was made under this claim
};

}  // namespace palpate::transport
