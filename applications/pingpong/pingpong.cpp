#include "applications/pingpong/pingpong.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace palpate::applications::pingpong {
namespace {

constexpr int kServesPrepared = 64;
constexpr double kTeleport_m = 0.15;      // a bat that moves further in one step was put there, not swung
constexpr double kBehind_m = 0.45;        // beyond the near edge a ball is out of reach
constexpr double kBehindWall_m = 0.10;    // over the wall
constexpr double kBelow_m = 0.12;         // below the table
constexpr double kLongestFlight_s = 3.0;  // from serve or wall: whatever happens, then comes the next serve

std::array<std::vector<physics::BallState>, kLevels> prepared_serves(const scene::SceneDescription& scene,
                                                                     const GameSettings& game,
                                                                     const BallWorld& world,
                                                                     const Settings& settings) {
  std::array<std::vector<physics::BallState>, kLevels> serves;
  if (game.match.serves == 0) {
    Random random(settings.seed, "pingpong/serve");
    serves.front() = make_serves(scene, game, world, settings.serve, kServesPrepared, random);
    return serves;
  }
  for (int level = 1; level <= kLevels; ++level) {
    Random random(settings.seed, fmt::format("pingpong/serve/{}", level));
    const LevelServes wanted = serves_of_level(level);
    GameSettings of_level = game;
    of_level.serve_speed = wanted.speed;
    ServeSettings aimed = settings.serve;
    aimed.aim_sd = wanted.aim_sd;
    serves[static_cast<std::size_t>(level - 1)] =
        make_serves(scene, of_level, world, aimed, kServesPrepared, random);
  }
  return serves;
}

}  // namespace

PingPong::PingPong(const scene::SceneDescription& scene, const Settings& settings)
    : scene_(scene),
      game_(game_settings(scene)),
      settings_(settings),
      world_(scene, game_),
      match_(game_.match),
      serves_(prepared_serves(scene, game_, world_, settings)) {
  const auto& c = find_surface(scene, "table").corners;
  const Vector3 right = (c[1] - c[0]).normalized();
  up_ = (c[1] - c[0]).cross(c[3] - c[0]).normalized();
  near_ = right.cross(up_);
  edge_ = 0.5 * (c[0] + c[1]);
  depth_ = (c[3] - c[0]).norm();
}

void PingPong::reset() {
  counters_.fill(0);
  match_ = Match(game_.match);
  if (match_.has_end()) next_serve_ = 0;
  started_ = -1.0;
}

void PingPong::step(Instant<PhysicsClock> now, Duration dt, const scene::TipState& tip,
                    scene::SceneState& state) {
  const double t = now.seconds(), h = to_seconds(dt);
  const Pose<Tip, Bat> X_tip_bat{Quaternion::Identity(), scene_.carried_offset};
  const auto X_world_bat = tip.X_world_tip * X_tip_bat;
  const bool seen = X_world_bat.translation.allFinite();
  if (!has_bat_ || (X_world_bat.translation - bat_before_.translation).norm() > kTeleport_m)
    bat_before_ = X_world_bat;
  has_bat_ = has_bat_ || seen;
  const Vector3 lever = X_world_bat.translation - tip.X_world_tip.translation;
  const BatMotion bat{bat_before_, X_world_bat, tip.velocity + tip.angular_velocity.cross(lever),
                      tip.angular_velocity};
  if (seen) bat_before_ = X_world_bat;

  if (!paused()) schedule(t, h);
  if (!paused() && h > 0.0 && (phase() == Phase::incoming || phase() == Phase::outgoing)) {
    for (const CollisionEvent& touch : world_.step(h, bat, seen)) {
      ++ball_jumps_;
      if (touch.what == Touched::bat) feel(touch, now - seconds(h - touch.at));
      judge(touch, t);
      if (phase() == Phase::waiting) break;
    }
    watch_limits(t);
  }

  state.body_count = 2;
  auto& ball = state.bodies[kBall];
  const physics::BallState& b = world_.ball();
  ball.visible = phase() != Phase::waiting;
  ball.set_p(world_.drawn_position());
  const bool flies = phase() == Phase::incoming || phase() == Phase::outgoing;
  ball.set_v(flies && !paused() ? b.velocity : Vector3::Zero());
  ball.set_w(flies && !paused() ? b.spin : Vector3::Zero());
  if (flies && !paused()) ball.set_q((so3_exp(h * b.spin) * ball.q()).normalized());
  ball.jumps = ball_jumps_;
  auto& body = state.bodies[kBat];
  body.visible = seen;
  if (seen) {
    body.set_p(X_world_bat.translation);
    body.set_q(X_world_bat.rotation);
    body.set_v(bat.velocity);
    body.set_w(bat.angular_velocity);
  }
  tell_match();
  state.counters = counters_;
  const Vector3 force = flies ? world_.contact_force() : Vector3::Zero();
  state.impact.force = {force.x(), force.y(), force.z()};
  // An impact that began at this very instant has a share of 0, which would read as none.
  state.impact.share = flies && world_.in_contact() ? std::max(world_.contact_progress(), 1e-6) : 0.0;
  const Vector3 point = world_.contact_point();
  state.impact.point = {point.x(), point.y(), point.z()};
}

void PingPong::schedule(double now, double dt) {
  if (started_ < 0.0) {
    started_ = now - dt;
    next_time_ = started_ + settings_.first_serve_s;
    set_phase(Phase::waiting);
  }
  if (match_.over()) {
    if (!serve_now_ && now < next_time_) return;
    match_.begin_next();
    next_serve_ = 0;
    next_time_ = now + settings_.pause_s + settings_.ready_s;
    serve_now_ = false;
  }
  if (serve_now_) {
    serve_now_ = false;
    if (phase() == Phase::incoming || phase() == Phase::outgoing) end(now, false);
    next_time_ = now;
  }
  if (phase() == Phase::waiting && now >= next_time_ - settings_.ready_s) {
    world_.place({serves()[next_serve_].position, Vector3::Zero(), Vector3::Zero()});
    ++ball_jumps_;
    set_phase(Phase::ready);
  }
  if (phase() == Phase::ready && now >= next_time_) throw_ball(now);
}

void PingPong::throw_ball(double now) {
  world_.place(serves()[next_serve_]);
  next_serve_ = (next_serve_ + 1) % serves().size();
  match_.serve();
  ++ball_jumps_;
  ++count(kServes);
  count(kRally) = 0;
  bounces_since_hit_ = 0;
  bounced_ = false;
  off_wall_at_ = now;
  set_phase(Phase::incoming);
}

void PingPong::judge(const CollisionEvent& touch, double now) {
  switch (touch.what) {
    case Touched::table:
      ++count(kTableBounces);
      ++bounces_since_hit_;
      if (bounces_since_hit_ >= 2) end(now, true);
      break;
    case Touched::wall:
      ++count(kWallBounces);
      if (phase() != Phase::outgoing) break;
      if (++count(kRally) == 1) ++count(kReturned);
      match_.bring_back(count(kRally) == 1);
      count(kLongest) = std::max(count(kLongest), count(kRally));
      bounces_since_hit_ = 0;
      off_wall_at_ = now;
      set_phase(Phase::incoming);
      if (settings_.pace_s > 0.0) {
        const double served = started_ + settings_.first_serve_s;
        const double due = served + settings_.pace_s * count(kServes) + settings_.credit_s;
        const double asked = count(kRally) == 1 ? settings_.rally_begins_s : settings_.next_return_s;
        if (now + asked > due) end(now, false);
      }
      break;
    case Touched::bat:
      ++count(kHits);
      bounces_since_hit_ = 0;
      set_phase(Phase::outgoing);
      break;
    case Touched::bat_released:
      break;
    case Touched::bat_cut_short:
      ++count(kSecondContacts);
      break;
    case Touched::squeezed:
      end(now, true);
      break;
  }
}

// A ball that nobody can reach any more is out of play.
void PingPong::watch_limits(double now) {
  if (phase() != Phase::incoming && phase() != Phase::outgoing) return;
  const Vector3 p = world_.ball().position - edge_;
  const double above = up_.dot(p), behind = near_.dot(p);
  if (!p.allFinite() || above < -kBelow_m || behind > kBehind_m || behind < -depth_ - kBehindWall_m ||
      p.norm() > 3.0 || now - off_wall_at_ > kLongestFlight_s) {
    end(now, true);
  }
}

void PingPong::end(double now, bool missed) {
  if (missed && count(kRally) == 0) ++count(kMisses);
  set_phase(Phase::waiting);
  ++ball_jumps_;
  match_.end_serve();
  next_time_ = now + (match_.over() ? settings_.over_s : settings_.pause_s + settings_.ready_s);
}

void PingPong::tell_match() {
  if (!match_.has_end()) return;
  count(kMatchServes) = match_.serves();
  count(kMatchReturned) = match_.returned();
  count(kPoints) = match_.points();
  count(kBest) = match_.best();
  const int next = std::min(match_.level() + (match_.won() ? 1 : 0), kLevels);
  count(kLevel) = match_.over() ? -next : match_.level();
}

void PingPong::feel(const CollisionEvent& touch, Instant<PhysicsClock> start) {
  ++event_.number;
  event_.start = start;
  event_.duration = seconds(touch.duration);
  event_.direction = -touch.normal;
  event_.point = touch.point;
  event_.approach_speed = touch.approach_speed;
  event_.mass = world_.effective_mass();
  event_.restitution = touch.restitution;
  event_.model = game_.contact_model;
}

}  // namespace palpate::applications::pingpong
