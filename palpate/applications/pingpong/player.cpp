#include "palpate/applications/pingpong/player.h"

#include <algorithm>
#include <cmath>

namespace palpate::pingpong {
namespace {

constexpr double kCommit_s = 0.08;       // nearer than this to the stroke nothing is changed any more
constexpr double kLeastNotice_s = 0.07;  // a stroke that would have to come sooner is let go
constexpr double kSteady_s =
    0.005;  // the bat has its speed that long before the meeting, so that a late ball is no matter
constexpr double kFollow_s = 0.030;  // the bat keeps its speed that long after the meeting
constexpr double kAsk = 0.95;        // share of the allowed acceleration a stroke may ask for
constexpr double kHomeward_s = 0.30;
constexpr double kLookAhead_s = 1.6;
constexpr double kSwing_s = 0.22;   // a swing likes to have that much time
constexpr double kLowest_m = 0.07;  // over the table no ball is met
constexpr std::size_t kTries = 10;  // places of a flight that are tried for a stroke
// Shares of the usual speed and height at the wall: what a stroke may fall back to.
constexpr std::array<std::array<double, 2>, 4> kGentler{{{1.0, 1.0}, {0.85, 0.85}, {0.8, 0.6}, {0.7, 0.4}}};
constexpr double kTurned_s = 0.04;  // the blade is turned that long before the meeting
constexpr double kWristLead = 2.0;  // what a critically damped wrist lags a steady turn, in 1 / its rate
constexpr double kTilt = -0.6;      // rad: the handle leans that much to the right, as a right hand holds it

double smooth(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

}  // namespace

ScriptedPlayer::ScriptedPlayer(const SceneDescription& scene, const Reach& reach,
                               const PlayerSettings& settings)
    : scene_(scene),
      reach_(reach),
      settings_(settings),
      random_(settings.seed, "pingpong/player"),
      home_(reach.home()),
      hand_(settings.hand, settings.max_acceleration, home_) {
  const BallWorld world(scene);
  model_ = world.model();
  bat_ = world.bat_law();
  const auto &table = find_surface(scene, "table"), &wall = find_surface(scene, "wall");
  planes_ = {bounce_plane(table.corners, scene.ball_radius, world.table_law()),
             bounce_plane(wall.corners, scene.ball_radius, world.wall_law())};
  up_ = planes_[0].normal;
  right_ = (table.corners[1] - table.corners[0]).normalized();
  near_ = right_.cross(up_);
  wall_middle_ = 0.5 * (wall.corners[0] + wall.corners[1]) + scene.ball_radius * planes_[1].normal;
  table_middle_ = planes_[0].point;
  home_rotation_ = hold((-near_ + 0.25 * up_).normalized());
  meeting_ = home_ - tip_for(Vector3::Zero(), home_rotation_ * Vector3::UnitY(), home_rotation_);
  choose_return();
  plan_.path =
      Quintic({home_, Vector3::Zero(), Vector3::Zero()}, {home_, Vector3::Zero(), Vector3::Zero()}, 1.0);
  plan_.rotation_from = plan_.rotation_to = home_rotation_;
}

void ScriptedPlayer::show(const WorldState& state, Instant<PhysicsClock> displayed) {
  waiting_.push_back({state, displayed + seconds(settings_.reaction_s)});
}

std::optional<Instant<PhysicsClock>> ScriptedPlayer::planned_hit() const {
  if (!plan_.stroke) return std::nullopt;
  return Instant<PhysicsClock>::from_seconds(plan_.hit);
}

// Orientation of the stylus with the bat's front along `normal`: blade above the hand, handle leaning to the
// side.
Quaternion ScriptedPlayer::hold(const Vector3& normal) const {
  // Bat y = normal; stylus z (away from the blade) as far down as the face allows, then turned about the
  // normal.
  const Vector3 down = (-up_ + up_.dot(normal) * normal).normalized();
  Matrix3 R;
  R.col(1) = normal;
  R.col(2) = down;
  R.col(0) = normal.cross(down);
  return Quaternion(R) * Quaternion(Eigen::AngleAxisd(kTilt, Vector3::UnitY()));
}

Vector3 ScriptedPlayer::tip_for(const Vector3& ball, const Vector3& normal, const Quaternion& R) const {
  const Vector3 centre = ball - (scene_.ball_radius + 0.5 * BallWorld::kBatThickness) * normal;
  return centre - R * scene_.bat_offset;
}

Stroke ScriptedPlayer::stroke_for(const BallState& in, const Vector3& v_out) const {
  // Without friction dv = (1 + e) (u - v.n) n; friction is corrected for by aiming off until the bounce comes
  // out right.
  Stroke stroke;
  Vector3 aim = v_out;
  for (int i = 0; i < 6; ++i) {
    const Vector3 dv = aim - in.velocity;
    stroke.normal = dv.normalized();
    stroke.speed =
        std::clamp(dv.norm() / (1.0 + bat_.restitution) + stroke.normal.dot(in.velocity), 0.1, 1.8);
    const BallState out = bounce(model_, in, stroke.normal, bat_, stroke.speed * stroke.normal);
    aim += 0.7 * (v_out - out.velocity);
  }
  return stroke;
}

// Back to the wall: at a place above the table, half way between here and where the ball is wanted back.
// Aims, looks in thought where the ball would go, and aims off.
Stroke ScriptedPlayer::aim(const BallState& in, double speed, double height) const {
  const Vector3 goal =
      wall_middle_ + height * up_ + right_.dot(0.5 * (in.position + meeting_) - wall_middle_) * right_;
  const Vector3 way = goal - in.position;
  const double time = std::abs(near_.dot(way)) / speed;
  Vector3 v_out = way / time - 0.5 * time * model_.gravity;
  Stroke stroke;
  for (int i = 0; i < 4; ++i) {
    stroke = stroke_for(in, v_out);
    BallState ball = bounce(model_, in, stroke.normal, bat_, stroke.speed * stroke.normal);
    constexpr double kStep = 0.01, kLongest = 1.0;
    double t = 0.0;
    while (t < kLongest && near_.dot(ball.position - goal) > 0.0) {
      ball = fly(model_, ball, kStep);
      t += kStep;
    }
    if (t >= kLongest) break;
    const Vector3 miss = goal - ball.position;
    v_out += (miss - near_.dot(miss) * near_) / t;
  }
  return stroke;
}

// How fast and how high at the wall a ball must be sent back so that it returns to where it can be met again,
// over one bounce: tried in thought once, with the ball that usually comes.
void ScriptedPlayer::choose_return() {
  const BallState usual{meeting_, 1.3 * near_ - 0.3 * up_, Vector3::Zero()};
  double best = 1e9;
  for (double speed = 2.0; speed < 3.45; speed += 0.1) {
    for (double height = 0.20; height < 0.50; height += 0.025) {
      const Stroke stroke = aim(usual, speed, height);
      BallState ball = bounce(model_, usual, stroke.normal, bat_, stroke.speed * stroke.normal);
      double t = 0.0;
      int table = 0;
      constexpr double kStep = 0.005, kLongest = 2.0;
      bool back = false;
      while (t < kLongest && !(back && near_.dot(ball.position - meeting_) >= 0.0)) {
        const bool away = near_.dot(ball.velocity) < 0.0;
        table += advance(model_, planes_, ball, kStep);
        if (away && near_.dot(ball.velocity) > 0.0) {
          back = true;
          table = 0;
        }
        t += kStep;
      }
      if (t >= kLongest || table != 1) continue;
      const Vector3 miss = ball.position - meeting_;
      const double cost = std::abs(up_.dot(miss)) + 0.1 * std::abs(up_.dot(ball.velocity)) + 0.05 * t;
      if (cost < best) {
        best = cost;
        return_speed_ = speed;
        return_height_ = height;
      }
    }
  }
}

void ScriptedPlayer::notice(const WorldState& state, double now) {
  const auto& ball = state.bodies[kBall];
  const std::array<std::int32_t, 2> score{state.counters[kServes], state.counters[kHits]};
  const auto phase = static_cast<Phase>(state.counters[kPhase]);
  if (score != score_) {
    score_ = score;
    seen_.clear();
    aim_error_ = {random_.normal(settings_.aim_sd), random_.normal(settings_.aim_sd),
                  random_.normal(settings_.aim_sd)};
  }
  if (ball.visible == 0 || phase == Phase::waiting || phase == Phase::ready) {
    seen_.clear();
    if (plan_.stroke && plan_.hit > now + kCommit_s) go_home(now);
    return;
  }
  if (state.contact > 0.0) return;
  const Vector3 noise(random_.normal(settings_.perception_sd), random_.normal(settings_.perception_sd),
                      random_.normal(settings_.perception_sd));
  const double t = state.time.seconds();
  if (!seen_.empty() && t <= seen_.back().time) return;
  seen_.push_back({t, ball.p() + noise});
  think(now);
}

void ScriptedPlayer::think(double now) {
  if (plan_.stroke && now > plan_.hit - kCommit_s && now < plan_.hit + 0.1) return;
  if (seen_.size() < 3) return;
  const auto fit = fit_flight(model_, planes_, seen_);
  if (!fit) return;
  // Follow the flight ahead; remember the places within reach, and what each asks of the arm.
  struct Place {
    double cost, time;
    BallState ball;
  };
  std::vector<Place> places;
  BallState ball = fit->state;
  double t = fit->time;
  int bounces = 0;
  bool turned_back = near_.dot(ball.velocity) > 0.0;
  constexpr double kStep = 0.005;
  const Vector3 usual = tip_for(Vector3::Zero(), home_rotation_ * Vector3::UnitY(), home_rotation_);
  while (t < now + kLookAhead_s) {
    const bool away = near_.dot(ball.velocity) < 0.0;
    const int n = advance(model_, planes_, ball, kStep);
    t += kStep;
    if (away && near_.dot(ball.velocity) > 0.0) {
      turned_back = true;  // off the wall
      bounces = 0;
    } else if (turned_back) {
      bounces += n;
    }
    if (bounces >= 2) break;
    if (!turned_back || bounces == 0 || t < now + kLeastNotice_s) continue;
    const Vector3 tip = ball.position + usual;
    if (!reach_.contains(tip) || up_.dot(ball.position - table_middle_) < kLowest_m) continue;
    double cost = (tip - home_).norm() + 0.03 * std::abs(up_.dot(ball.velocity));
    if (t < now + kSwing_s) cost += 0.5 * (now + kSwing_s - t);
    if (plan_.stroke) cost += 0.2 * std::abs(t - plan_.hit);
    places.push_back({cost, t, ball});
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.cost < b.cost; });
  // The best place to which there is a way, with a gentler stroke where the full one asks too much.
  const std::size_t stride = std::max<std::size_t>(1, places.size() / kTries);
  for (std::size_t i = 0; i < places.size(); i += stride) {
    for (const auto& [faster, higher] : kGentler) {
      if (const auto plan = swing_to(places[i].ball, places[i].time, faster, higher, now)) {
        plan_ = *plan;
        return;
      }
    }
  }
  if (plan_.stroke) go_home(now);
}

// The way from where the hand is to a meeting with the ball, if the arm can go it.
std::optional<ScriptedPlayer::Plan> ScriptedPlayer::swing_to(const BallState& ball, double hit, double faster,
                                                             double higher, double now) const {
  const Stroke stroke = aim(ball, faster * return_speed_, higher * return_height_);
  const Quaternion R = hold(stroke.normal);
  HandState to;
  to.velocity = stroke.speed * stroke.normal;
  to.position = tip_for(ball.position, stroke.normal, R) + aim_error_ - kSteady_s * to.velocity;
  const Quintic path(planned(now), to, hit - kSteady_s - now);
  if (path.largest_acceleration() > kAsk * settings_.max_acceleration) return std::nullopt;
  if (path.largest_speed() > settings_.max_speed || !reach_.contains(path)) return std::nullopt;
  // Room to follow through and to come back.
  HandState after = to;
  after.position += (kSteady_s + kFollow_s) * to.velocity;
  if (!reach_.contains(after.position) || !reach_.contains(way_home(after))) return std::nullopt;
  return Plan{now, hit, true, path, turned(now), R};
}

// Back to the middle; a little faster or slower where that keeps the arm within its reach.
Quintic ScriptedPlayer::way_home(const HandState& from) const {
  const HandState home{home_, Vector3::Zero(), Vector3::Zero()};
  // Least jerk: the largest acceleration is about 6 d / T^2, and what is left of the swing must be braked.
  const double d = (home_ - from.position).norm();
  const double T = std::max({kHomeward_s, std::sqrt(8.0 * d / settings_.max_acceleration),
                             5.0 * from.velocity.norm() / settings_.max_acceleration});
  for (const double share : {1.0, 0.8, 1.25, 0.65}) {
    const Quintic path(from, home, share * T);
    if (path.largest_acceleration() < settings_.max_acceleration && reach_.contains(path)) return path;
  }
  return {from, home, T};
}

void ScriptedPlayer::go_home(double now) {
  const Quintic path = way_home(planned(now));
  const Quaternion turned_now = turned(now);
  plan_ = {now, now + path.duration(), false, path, turned_now, home_rotation_};
}

HandState ScriptedPlayer::planned(double t) const {
  HandState s = plan_.path.at(t - plan_.begin);
  const double over = t - plan_.begin - plan_.path.duration();
  if (over > 0.0) {
    s.position += over * s.velocity;
    s.acceleration.setZero();
  }
  return s;
}

Quaternion ScriptedPlayer::turned(double t) const {
  const double span = std::max(0.02, plan_.hit - kTurned_s - plan_.begin);
  return plan_.rotation_from.slerp(smooth((t - plan_.begin) / span), plan_.rotation_to);
}

HandTarget ScriptedPlayer::act(Instant<PhysicsClock> instant) {
  const double now = instant.seconds();
  if (!started_) {
    started_ = true;
    plan_.begin = now;
    plan_.hit = now;
  }
  while (!waiting_.empty() && waiting_.front().ready <= instant) {
    const WorldState state = waiting_.front().state;
    waiting_.pop_front();
    notice(state, now);
  }
  if (plan_.stroke && now > plan_.hit + kFollow_s) go_home(now);

  const HandState& target = hand_.follow(
      now, [this](double t) { return planned(t); },
      [this](double t) {
        const double tau = t - plan_.begin;
        const bool on = tau >= 0.0 && tau < plan_.path.duration();
        return on ? plan_.path.jerk(tau) : Vector3(Vector3::Zero());
      });
  return {{target.position}, target.velocity, turned(now + kWristLead / settings_.wrist_rate)};
}

}  // namespace palpate::pingpong
