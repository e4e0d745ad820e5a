// What an application alone understands, on its way through parts that do not: bytes, and the version of
// their form. Who carries it looks at its size only. Values; any thread.
#pragma once

#include <cstdint>
#include <string>

namespace palpate::scene {

// Room for the largest payload and a description with 64 surfaces in one message (transport/messages.h).
inline constexpr std::size_t kMaxPayloadBytes = 32 * 1024;

struct Payload {
  std::uint32_t version = 0;  // 0: there is none, and no bytes
  std::string bytes;

  bool operator==(const Payload&) const = default;
};

}  // namespace palpate::scene
