// What a recording holds of the physics server's loops, in memory: message by message, as bytes that are read when their turn
// comes: a few hundred bytes a tick. Private to the module.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/record/session/physics_ticks.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"
#include "palpate/server/physics/recorded_setup.h"

namespace palpate::server::physics {

// Messages behind each other in one block.
class MessageList {
 public:
  void add(std::string_view bytes) {
    block_.append(bytes);
    ends_.push_back(block_.size());
  }
  std::size_t size() const { return ends_.size(); }
  std::string_view operator[](std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : ends_[i - 1];
    return std::string_view(block_).substr(begin, ends_[i] - begin);
  }

 private:
  std::string block_;
  std::vector<std::size_t> ends_;
};

// Of a state's message: equal for equal states.
std::uint64_t digest(std::string_view bytes);

struct RecordedTicks {
  rig::Rig rig;
  scene::SceneDescription scene;
  RecordedSetup setup;
  MessageList samples, forces, steps;
  std::string lost;                   // what the file lacks of itself, in words; empty: nothing
  bool cut = false;                   // a part of another (`palpate recording cut`)
  std::vector<std::uint64_t> states;  // digests of the messages, one for each step in which the world moved

  // Refused where the file is none, or lacks what is needed; a fault of the file that costs no message of these is none.
  static Expected<RecordedTicks> read(const std::filesystem::path& recording);

  Expected<record::session::RecordedHapticTick> tick(std::size_t i) const;  // sample and force
  Expected<record::session::RecordedStep> step(std::size_t i) const;
};

}  // namespace palpate::server::physics
