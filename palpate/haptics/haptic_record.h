// What the haptic loop keeps of each tick, for whoever wants to know what happened.
//
// One writer (the haptic thread), any number of readers, nobody waits. Names of the columns carry the units.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "palpate/core/broadcast_ring.h"
#include "palpate/device/joints.h"
#include "palpate/haptics/force_guard.h"
#include "palpate/haptics/guest.h"
#include "palpate/math/so3.h"
#include "palpate/time/instant.h"

namespace palpate::haptics {

struct HapticRecord {
  Instant<PhysicsClock> time;
  device::JointVector joints;         // rad
  Vector3 tip, requested, commanded;  // m, N in World; N in ArmBase
  ForceFault fault = ForceFault::none;
  ForceState state = ForceState::ready;
  double speed = 0.0;     // of the tip, m/s
  double outage_s = 0.0;  // of the outage under way or of the last one, as device::ForceStrength counts it
};

// Forces were on and a fault took them, or it made the state safe. An outage or a trip: how long it lasts tells
// (LoggedTrip).
struct HapticTrip {
  std::uint64_t tick = 0;  // 1, 2, ...
  Instant<PhysicsClock> time;
  ForceFault fault = ForceFault::none;
  Guest culprit = Guest::none;
};

class HapticRecords {
 public:
  // 8 s at 1 kHz, 2 s at 4 kHz.
  static constexpr std::size_t capacity() { return kSlots - 2; }

  void push(const HapticRecord& r) noexcept {
    Packed p;
    p.time_ns = r.time.ns();
    p.speed = r.speed;
    p.outage_s = r.outage_s;
    p.fault = static_cast<std::uint8_t>(r.fault);
    p.state = static_cast<std::uint8_t>(r.state);
    p.joint_count = static_cast<std::uint8_t>(r.joints.size());
    double* to = p.numbers.data();
    for (const Vector3* v : {&r.tip, &r.requested, &r.commanded})
      for (int i = 0; i < 3; ++i) *to++ = (*v)[i];
    for (const double angle : r.joints) *to++ = angle;
    ring_.push(p);
  }
  std::uint64_t count() const noexcept { return ring_.count(); }
  // Record k, 0 = the first ever; nothing where it has been overwritten.
  std::optional<HapticRecord> read(std::uint64_t k) const {
    Packed p;
    if (!ring_.read(k, p)) return std::nullopt;
    const auto at = [&p](std::size_t i) { return Vector3(p.numbers[i], p.numbers[i + 1], p.numbers[i + 2]); };
    return HapticRecord{{Duration(p.time_ns)},
                        Eigen::Map<const Eigen::VectorXd>(p.numbers.data() + 9, p.joint_count),
                        at(0),
                        at(3),
                        at(6),
                        static_cast<ForceFault>(p.fault),
                        static_cast<ForceState>(p.state),
                        p.speed,
                        p.outage_s};
  }

 private:
  struct Packed {
    std::int64_t time_ns = 0;
    std::array<double, 9 + device::kMostJoints> numbers{};
    double speed = 0.0, outage_s = 0.0;
    std::uint8_t fault = 0, state = 0, joint_count = 0;
    std::array<std::uint8_t, 5> unused{};
  };
  static constexpr std::size_t kSlots = 8192;
  BroadcastRing<Packed, kSlots> ring_;
};

}  // namespace palpate::haptics
