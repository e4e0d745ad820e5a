// What the physics server's two loops were given and did, tick by tick, on its way to whoever records it.
//
// Each ring has one writer, the loop's thread, which takes no lock and no memory, and any number of readers, which never
// make it wait: who comes too late finds an entry overwritten. 8 s at 1 kHz.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "palpate/core/broadcast_ring.h"
#include "palpate/haptics/haptic_tick.h"
#include "palpate/scene/application.h"
#include "palpate/scene/scene_state.h"
#include "palpate/time/input_trace.h"

namespace palpate::record::session {

// Numbers a tick has learned (palpate/time/input_trace.h); `exact`: these are all.
struct TickInputs {
  bool exact = true;
  std::vector<std::uint64_t> values;
};

struct RecordedHapticTick {
  haptics::HapticTick tick;
  TickInputs inputs;
};

// A step of the physics loop.
struct RecordedStep {
  std::uint64_t number = 0;              // 1, 2, ... of the calls
  Instant<PhysicsClock> now;             // what it was called with
  std::vector<scene::Control> controls;  // carried out before it
  std::uint64_t controls_left_out = 0;   // more than there is room for
  TickInputs inputs;
  std::optional<scene::SceneState> state;  // as it has left the world; none: the world did not move
};

class HapticTickRing {
 public:
  static constexpr std::size_t capacity() { return kSlots - 2; }
  void push(const haptics::HapticTick& tick, const InputTrace& trace) noexcept;
  std::uint64_t count() const noexcept { return ring_.count(); }
  // Entry k, 0 = the first ever; nothing where it has been overwritten, or is not there yet.
  std::optional<RecordedHapticTick> read(std::uint64_t k) const;

 private:
  struct Packed {
    std::uint64_t number = 0;
    std::int64_t begun_ns = 0, stamp_ns = 0, waited_ns = 0;
    // gimbal, withheld, held, tip, continuous, impact, commanded; then speed; then the joints.
    std::array<double, 22 + device::kMostJoints> numbers{};
    std::array<std::uint64_t, InputTrace::kMost> inputs{};
    std::uint32_t buttons = 0;
    std::uint8_t joints = 0, connected = 0, have_held = 0, state = 0, fault = 0, culprit = 0, input_count = 0,
                 exact = 0;
    std::uint32_t unused = 0;
  };
  static constexpr std::size_t kSlots = 8192;
  BroadcastRing<Packed, kSlots> ring_;
};

class StepRing {
 public:
  static constexpr std::size_t kMostControls = 8;  // before one step
  static constexpr std::size_t capacity() { return kSlots - 2; }
  // The physics thread: what is wished before the next step.
  void control(scene::Control control) noexcept;
  // `state`: null where the world has not moved.
  void push(Instant<PhysicsClock> now, const scene::SceneState* state, const InputTrace& trace) noexcept;
  std::uint64_t count() const noexcept { return ring_.count(); }
  std::optional<RecordedStep> read(std::uint64_t k) const;

 private:
  struct Packed {
    std::int64_t now_ns = 0;
    std::array<std::uint64_t, InputTrace::kMost> inputs{};
    std::array<scene::Control, kMostControls> controls{};
    std::uint8_t input_count = 0, exact = 0, control_count = 0, moved = 0;
    std::uint32_t controls_left_out = 0;
    scene::SceneState state;  // last: bodies beyond body_count are not copied

    std::size_t used_bytes() const noexcept { return offsetof(Packed, state) + state.used_bytes(); }
    void clear_unused() noexcept { state.clear_unused(); }
  };
  static constexpr std::size_t kSlots = 8192;
  BroadcastRing<Packed, kSlots> ring_;
  Packed next_;
};

struct PhysicsTicks {
  HapticTickRing haptic;
  StepRing steps;
};

}  // namespace palpate::record::session
