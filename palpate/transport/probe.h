// Who answers at an address, and what the exchange is made of: for a person who looks for what is wrong.
//
// Any thread. A look takes as long as it is given and changes nothing at the other side, where it counts as a
// client for a second. Times in seconds.
#pragma once

#include <optional>
#include <string>

#include "palpate/transport/keys.h"
#include "palpate/transport/local_endpoint.h"

namespace palpate::transport {

struct NetworkLibraries {
  std::string zeromq;          // version that runs
  std::string protobuf;        // version compiled with; another one would not have started
  bool curve = false;          // ZeroMQ can encrypt
  std::uint32_t protocol = 0;  // of our messages
};
NetworkLibraries network_libraries();

enum class Answer {
  nobody,          // no sign of anybody
  physics_server,  // answers us
  not_admitted,    // a physics server with the expected key, which does not admit ours
  stranger,        // something listens that does not answer as a physics server does
};
struct Answered {
  Answer who = Answer::nobody;
  std::optional<Role> role;  // ours there, of a physics server
  std::string trouble;       // where no physics server answers and it is known: what went wrong
};
// Waits up to `patience_s` for an answer. Encrypted addresses need `identity`. Refused where no connection
// can be tried.
Expected<Answered> who_answers(const Endpoint& endpoint, const std::optional<ClientIdentity>& identity,
                               double patience_s);

// Whether a server could listen at this tcp:// address now: bound for a moment and let go.
struct Listening {
  bool possible = false, in_use = false;
  std::string reason;  // why not
};
Listening can_listen(const Endpoint& endpoint);

}  // namespace palpate::transport
