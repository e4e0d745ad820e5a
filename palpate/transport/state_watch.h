// An observer's end: states at a rate of its choice, without asking for each.
//
// One thread, which must call take() every second or more often: the subscription is renewed there, and
// lapses on the server's side after three. take() gives the newest state that has come since the last call
// and never waits; what came between is counted as skipped, what the wire dropped as missed.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "palpate/transport/keys.h"
#include "palpate/transport/local_endpoint.h"
#include "palpate/transport/messages.h"

namespace palpate::transport {

class StateWatch {
 public:
  virtual ~StateWatch() = default;
  virtual std::optional<StateReply> take() = 0;
  // Why the server sends nothing, where it has said so since the last state.
  virtual std::optional<std::string> refusal() const = 0;

  struct Counters {
    std::uint64_t taken = 0, skipped = 0;
    std::uint64_t missed = 0;    // by their numbers: dropped on the way, because nobody took them in time
    std::uint64_t rejected = 0;  // failed the check
  };
  virtual Counters counters() const = 0;
};

// `service` is the physics server's address, as for connect_states(). Wrong use: rates other than 1 to 1000
// Hz, an encrypted endpoint without keys.
Expected<std::unique_ptr<StateWatch>> watch_states(const Endpoint& service, int rate_hz,
                                                   const std::optional<ClientIdentity>& identity = {});

}  // namespace palpate::transport
