// Says who may talk to an encrypted physics server: ZeroMQ asks it about every client that wants to come in
// (ZAP, RFC 27), and the service about every message that one who is in has sent. Private to the engine.
//
// Admitted is who stands in authorized_keys. The file is looked at twice a second, so that a key taken out of
// it has no rights within half a second, connected or not. One thread, the service's network thread, but for
// role_of().
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>

#include "palpate/time/instant.h"
#include "palpate/transport/keys.h"
#include "palpate/transport/zmq_socket.h"

namespace palpate::transport::zmq {

// What a client that is turned away is told, in the numbers of ZAP: it gives up where it is not 300.
inline constexpr std::uint32_t kWelcome = 200, kNotAdmitted = 400, kNoPlace = 500;

class Authenticator {
 public:
  // Before the socket it guards is bound, and in the same context.
  static Expected<Authenticator> make(const Context& context, ServerIdentity identity);

  // Makes `socket` take encrypted connections of admitted clients only.
  Expected<void> guard(Socket& socket) const;

  void* get() const { return socket_.get(); }
  // Answers the questions that have come. `full`: whether a key has all the connections it may have.
  void answer(const std::function<bool(const std::string& key)>& full);
  // Reads authorized_keys anew where it has changed. True where somebody has lost the right to be here. A
  // file that cannot be read for want of descriptors or memory is tried again; until then the list stays as
  // it was.
  bool look_again(Duration now);
  // Any thread.
  std::optional<Role> role_of(const std::string& user) const;
  std::uint64_t rejected_connections() const { return rejected_connections_; }

 private:
  Authenticator(Socket socket, ServerIdentity identity, AuthorizedKeys admitted)
      : socket_(std::move(socket)), identity_(std::move(identity)) {
    admitted_->list = std::move(admitted);
  }
  std::string stamp() const;

  // On the heap, as an authenticator is moved into its place. Changed by the one thread, under the mutex.
  struct Admitted {
    mutable std::mutex mutex;
    AuthorizedKeys list;
  };
  Socket socket_;  // REP
  ServerIdentity identity_;
  std::unique_ptr<Admitted> admitted_ = std::make_unique<Admitted>();
  std::string stamp_;  // of the file as it was read
  std::optional<Duration> looked_;
  std::uint64_t rejected_connections_ = 0;
};

// Makes a client's socket speak to the holder of that server key only.
Expected<void> encrypt(Socket& socket, const ClientIdentity& identity);

}  // namespace palpate::transport::zmq
