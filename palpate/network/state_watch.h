// An observer's end: states at a rate of its choice, without asking for each.
//
// One thread, which must call take() now and then: the connection's affairs are seen to there. take() gives
// the newest state that has come since the last call and never waits; what came between is counted as
// skipped, what the wire dropped as missed.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "palpate/network/keys.h"
#include "palpate/network/local_endpoint.h"
#include "palpate/network/messages.h"

namespace palpate {

class StateWatch {
 public:
  virtual ~StateWatch() = default;
  virtual std::optional<StateReply> take() = 0;

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

}  // namespace palpate
