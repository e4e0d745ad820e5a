// The gate before an encrypted physics server: ZeroMQ asks it about every client that wants to come in (ZAP,
// RFC 27), and the service about every message that one who is in has sent. Private to the engine.
//
// Admitted is who stands in authorized_keys. The file is looked at twice a second, so that a key taken out of
// it has no rights within half a second, connected or not. One thread, the service's network thread.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>

#include "palpate/network/keys.h"
#include "palpate/network/zmq_socket.h"
#include "palpate/time/instant.h"

namespace palpate::zmq {

inline constexpr std::string_view kRequestsDomain = "palpate", kStatesDomain = "palpate-states";

class Gate {
 public:
  // Before the socket it guards is bound, and in the same context.
  static Expected<Gate> make(const Context& context, ServerIdentity identity);

  // Makes `socket` (ROUTER, XPUB) take encrypted connections of admitted clients only.
  Expected<void> guard(Socket& socket, std::string_view domain = kRequestsDomain) const;

  // This key gets no states for a minute: it has abused them. Any thread; who is connected stays so.
  void keep_from_states(const std::string& user) const;

  void* get() const { return socket_.get(); }
  // Answers the questions that have come.
  void answer();
  // Reads authorized_keys anew where it has changed. True where somebody has lost the right to be here.
  bool look_again(Duration now);
  std::optional<Role> role_of(const std::string& user) const { return admitted_.role_of(user); }
  std::uint64_t turned_away() const { return turned_away_; }

 private:
  Gate(Socket socket, ServerIdentity identity, AuthorizedKeys admitted)
      : socket_(std::move(socket)), identity_(std::move(identity)), admitted_(std::move(admitted)) {}
  std::string stamp() const;
  bool kept_from_states(const std::string& user) const;

  // Until when, by key. On the heap, as a gate is moved into its place.
  struct Kept {
    std::mutex mutex;
    std::map<std::string, Duration> until;  // monotonic
  };
  std::unique_ptr<Kept> kept_ = std::make_unique<Kept>();
  Socket socket_;  // REP
  ServerIdentity identity_;
  AuthorizedKeys admitted_;
  std::string stamp_;  // of the file as it was read
  std::optional<Duration> looked_;
  std::uint64_t turned_away_ = 0;
};

// Makes a client's socket speak to the holder of that server key only.
Expected<void> encrypt(Socket& socket, const ClientIdentity& identity);

}  // namespace palpate::zmq
