// Ping-pong against the wall: rules on the physics side.
//
// A serve leaves the wall, bounces once on the table and is hit with the bat; it counts as returned when the
// ball then reaches the wall, directly or via the table. The rally goes on while the ball comes back. Bodies:
// 0 the ball, 1 the bat (Bat frame: disc centre, +y out of the front). Physics thread; step() does not
// allocate, lock, throw or write text.
#pragma once

#include <memory>
#include <vector>

#include "applications/pingpong/ball_world.h"
#include "applications/pingpong/match.h"
#include "applications/pingpong/serve.h"
#include "palpate/scene/application.h"

namespace palpate::applications::pingpong {

inline constexpr int kBall = 0, kBat = 1;

// Places in SceneState::counters.
enum Counter : std::size_t {
  kServes,
  kReturned,  // serves hit and brought to the wall
  kRally,     // times the ball was brought to the wall since the last serve
  kLongest,   // rally
  kHits,
  kMisses,  // serves that ended without a return
  kTableBounces,
  kWallBounces,
  kSecondContacts,  // surfaces met while the bat's contact lasted
  kPhase,           // a Phase
  kMatchServes,     // of the match; 0 where it has no end, as all below
  kMatchReturned,
  kPoints,
  kBest,   // points of a match since the start
  kLevel,  // negative: the match is over, and the next one has that level
};

enum class Phase : std::int32_t {
  waiting,   // no ball
  ready,     // the ball is shown where it will be served from
  incoming,  // on its way to the player
  outgoing,  // hit, on its way to the wall
};

struct Settings {
  ServeSettings serve;
  std::uint64_t seed = 1;
  double first_serve_s = 0.4;
  double ready_s = 0.15;  // the ball is shown that long before a serve
  double pause_s = 0.02;  // without a ball, between two serves
  double over_s = 10.0;   // after a match the next one begins by itself
  // A rally goes on only while the mean time between serves stays below this (0 = for ever), with this much
  // credit; what the game has saved is spent on rallies worth the name, not on one return here and there.
  double pace_s = 1.27;
  double credit_s = 2.7;
  double next_return_s = 0.95;  // what a further return costs, and getting ready for the next serve
  double rally_begins_s = 2.5;  // saved before a first return is followed by a second
};

class PingPong : public scene::Application {
 public:
  explicit PingPong(const scene::SceneDescription& scene, const Settings& settings = {});

  void step(Instant<PhysicsClock> now, Duration dt, const scene::TipState& tip,
            scene::SceneState& state) override;
  const scene::ImpactEvent& impact() const override { return event_; }

  const BallWorld& world() const { return world_; }

 private:
  void schedule(double now, double dt);
  void tell_match();
  void begin() override { serve_now_ = true; }
  void reset() override;
  void throw_ball(double now);
  void judge(const CollisionEvent& touch, double now);
  void watch_limits(double now);
  void end(double now, bool missed);
  void feel(const CollisionEvent& touch, Instant<PhysicsClock> start);
  std::int32_t& count(Counter c) { return counters_[c]; }
  Phase phase() const { return static_cast<Phase>(counters_[kPhase]); }
  void set_phase(Phase p) { counters_[kPhase] = static_cast<std::int32_t>(p); }

  scene::SceneDescription scene_;
  GameSettings game_;
  Settings settings_;
  BallWorld world_;
  Match match_;
  // Of each level; of a match without an end only the first, as it is set.
  std::array<std::vector<physics::BallState>, kLevels> serves_;
  const std::vector<physics::BallState>& serves() const {
    return serves_[match_.has_end() ? static_cast<std::size_t>(match_.level() - 1) : 0];
  }
  Vector3 up_, near_, edge_;  // table axes and the middle of its near edge
  double depth_ = 0.0;        // of the table, m
  std::size_t next_serve_ = 0;
  double started_ = -1.0, next_time_ = 0.0, off_wall_at_ = 0.0;  // s of the physics clock
  bool serve_now_ = false, bounced_ = false;
  int bounces_since_hit_ = 0;
  std::array<std::int32_t, scene::SceneState::kCounters> counters_{};
  std::uint32_t ball_jumps_ = 0;
  scene::ImpactEvent event_;
  bool has_bat_ = false;
  Pose<World, Bat> bat_before_;
};

}  // namespace palpate::applications::pingpong
