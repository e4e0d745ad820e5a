// Who is connected to the physics server, and whose connection has to end so that others find a place.
//
// Bookkeeping alone, without wire and thread; one thread. A connection is new until it says something, which
// clients do at once: until then it may be a stranger's in the middle of a handshake, or nobody's. From then
// on it is its user's: who holds a key, or, where nothing is encrypted, the process or host it comes from.
// What a user may have is bounded; a connection beyond that stays new, nothing it says is heard, and like all
// that stay new it ends. Where many are new those that have been so for longest end first, of the source that
// has most of them: who means to speak has long spoken.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "palpate/time/instant.h"

namespace palpate::transport {

class Connections {
 public:
  static constexpr std::size_t kMost = 320, kForOperators = 4;
  static constexpr std::size_t kMostOfKey = 8, kMostOfSource = 32;
  static constexpr std::size_t kFewNew = 10, kMostNew = 100;
  static constexpr Duration kNewFor = std::chrono::seconds(2);
  static constexpr Duration kNewForAmongMany = std::chrono::milliseconds(300);

  struct Ended {
    int descriptor = -1;
    std::uint64_t number = 0;
  };

  // How many connections there may be in all, as descriptors allow. Those that are there stay.
  void set_places(std::size_t places) { places_ = places; }
  // A connection from `source`, a host or a process, at this descriptor. `number`: the kernel's of the socket,
  // which is never given twice. `listener` took it, 0, 1 ...
  void began(int listener, int descriptor, std::uint64_t number, std::string source,
             Instant<PhysicsClock> now);
  // Told late by one listener, the descriptor may be that of another's connection by now.
  void ended(int listener, int descriptor);
  // Whether the user is the one this connection is known to be of.
  bool is_of(int descriptor, const std::string& key) const;
  // Something was said there. `key`: of who said it, empty where nothing is encrypted. False: not to be heard.
  bool heard(int descriptor, const std::string& key, bool by_operator);
  // The key has all the connections it may have.
  bool full(const std::string& key) const { return of_user(key) >= kMostOfKey; }
  // Takes one out of the list: that at this descriptor, where it is of this user or of none yet.
  std::optional<Ended> take(int descriptor, const std::string& key);
  // Those that this listener took. They stay in the list until their end is told.
  std::vector<Ended> of_listener(int listener) const;
  // Takes out of the list those that have to end now.
  std::vector<Ended> take_overdue(Instant<PhysicsClock> now);

  std::size_t size() const { return connections_.size(); }
  std::size_t of_user(const std::string& user) const;

 private:
  struct Connection {
    int listener = 0;
    std::uint64_t number = 0;
    std::string source, user;  // no user: new
    Instant<PhysicsClock> since;
  };
  using Entry = std::map<int, Connection>::iterator;
  std::size_t most_new() const;
  std::size_t for_operators() const;
  Entry one_too_many();

  std::size_t places_ = kMost;
  std::map<int, Connection> connections_;  // by descriptor
};

}  // namespace palpate::transport
