// The state of the virtual world at one moment: what the physics server keeps in its history and sends out.
//
// Fixed size and trivially copyable, so that one writer can hand it to many readers without locks. World
// frame, SI. What body 0, 1, ... and the counters mean is the application's business (see Application).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "palpate/math/pose.h"
#include "palpate/time/answer.h"
#include "palpate/time/instant.h"

namespace palpate::scene {

// Plain numbers (Eigen types are not trivially copyable). Conversions below.
struct BodyState {
  std::array<double, 3> position{};
  std::array<double, 4> orientation{1, 0, 0, 0};  // w x y z
  std::array<double, 3> velocity{};
  std::array<double, 3> angular_velocity{};
  // Counts jumps (impacts, serves): between two states whose counts differ no path may be interpolated
  // across.
  std::uint32_t jumps = 0;
  std::uint32_t visible = 1;

  Vector3 p() const { return Vector3(position.data()); }
  Vector3 v() const { return Vector3(velocity.data()); }
  Quaternion q() const { return {orientation[0], orientation[1], orientation[2], orientation[3]}; }
  void set_p(const Vector3& x) { position = {x.x(), x.y(), x.z()}; }
  void set_v(const Vector3& x) { velocity = {x.x(), x.y(), x.z()}; }
  void set_w(const Vector3& x) { angular_velocity = {x.x(), x.y(), x.z()}; }
  void set_q(const Quaternion& r) { orientation = {r.w(), r.x(), r.y(), r.z()}; }
};

// An impact under way, as a picture shows it and an ear hears it. The hand does not feel it from here: the
// haptic loop plays the ImpactEvent by itself. N on the hand and m, World.
struct ImpactProgress {
  double share = 0.0;  // of its duration that has passed, in (0, 1]; 0: there is none
  std::array<double, 3> force{}, point{};
};

// A force that is felt for as long as its reason lasts: a surface that is touched, a spring. What the haptic
// loop gives, within limits; where the application has a contact law, what that law has said. N on the hand
// and m, World.
struct ContinuousForce {
  std::array<double, 3> force{}, point{};
  std::uint32_t touching = 0, unused = 0;  // touching: 1 while there is a contact at `point`
};

struct SceneState {
  static constexpr int kBodies = 8;
  static constexpr int kCounters = 16;

  Instant<PhysicsClock> time;
  std::uint64_t tick = 0;
  std::array<std::int32_t, kCounters> counters{};
  ImpactProgress impact;
  ContinuousForce continuous;
  std::int32_t body_count = 0;
  std::array<BodyState, kBodies> bodies{};  // last: those beyond body_count are never copied (PartlyUsed)

  // Of a server that has made no step yet: nothing to draw. Steps count from 1.
  bool empty() const { return tick == 0; }
  // Both together: what the hand feels now, N, World.
  Vector3 felt_force() const { return Vector3(impact.force.data()) + Vector3(continuous.force.data()); }

  std::size_t used_bytes() const noexcept;
  void clear_unused() noexcept;
};
static_assert(std::is_trivially_copyable_v<SceneState>);

inline std::size_t SceneState::used_bytes() const noexcept {
  return offsetof(SceneState, bodies) +
         static_cast<std::size_t>(std::clamp(body_count, 0, kBodies)) * sizeof(BodyState);
}
inline void SceneState::clear_unused() noexcept {
  for (int i = std::clamp(body_count, 0, kBodies); i < kBodies; ++i)
    bodies[static_cast<std::size_t>(i)] = BodyState{};
}

// A state, and how a history or a server knew it.
using StateAnswer = HistoryAnswer<SceneState>;

// State between two neighbours, s in [0, 1]; a body whose jump count differs moves ballistically from the
// nearer side instead of being interpolated across the jump (gravity is the caller's, (0,0,0) for none).
SceneState interpolate(const SceneState& a, const SceneState& b, double s, const Vector3& gravity);

// State carried on by `ahead` from `a` at constant velocity.
SceneState extrapolate(const SceneState& a, Duration ahead);

}  // namespace palpate::scene
