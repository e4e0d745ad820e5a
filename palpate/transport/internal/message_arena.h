// Where a protobuf message lives while it is written or read: on the stack as far as it goes, for a state
// would otherwise take and give back two dozen small pieces of memory, each out of a cold cache. Private to
// messages.
#pragma once

#include <google/protobuf/arena.h>

#include <array>

namespace palpate::transport {

class MessageArena {
 public:
  MessageArena() : arena_(block_.data(), block_.size()) {}
  template <typename Wire>
  Wire& make() {
    return *google::protobuf::Arena::CreateMessage<Wire>(&arena_);
  }

 private:
  alignas(16) std::array<char, 4096> block_;  // a state of eight bodies takes about three quarters
  google::protobuf::Arena arena_;
};

}  // namespace palpate::transport
