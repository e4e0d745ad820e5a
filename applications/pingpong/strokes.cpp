#include "applications/pingpong/strokes.h"

#include <algorithm>
#include <cmath>

namespace palpate::applications::pingpong {
namespace {

constexpr double kStep_s = 0.001;  // no swing is shorter
constexpr double kSteady_s =
    0.005;  // the bat has its speed that long before the meeting, so that a late ball is no matter
constexpr double kAsk = 0.95;  // share of the allowed acceleration a stroke may ask for
constexpr double kHomeward_s = 0.30;
constexpr double kLowest_m = 0.07;  // over the table no ball is met
// Shares of the usual speed and height at the wall: what a stroke may fall back to.
constexpr std::array<std::array<double, 2>, 4> kGentler{{{1.0, 1.0}, {0.85, 0.85}, {0.8, 0.6}, {0.7, 0.4}}};
constexpr double kTurned_s = 0.04;  // the blade is turned that long before the meeting
constexpr double kTilt = -0.6;      // rad: the handle leans that much to the right, as a right hand holds it

double smooth(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

}  // namespace

scene::HandState Swing::at(double t) const {
  scene::HandState s = path.at(t - begin);
  const double over = t - begin - path.duration();
  if (over > 0.0) {
    s.position += over * s.velocity;
    s.acceleration.setZero();
  }
  return s;
}

Vector3 Swing::jerk(double t) const {
  const bool on = t >= begin && t - begin < path.duration();
  return on ? path.jerk(t - begin) : Vector3(Vector3::Zero());
}

Quaternion Swing::turned(double t) const {
  const double span = std::max(0.02, hit - kTurned_s - begin);
  return rotation_from.slerp(smooth((t - begin) / span), rotation_to);
}

Strokes::Strokes(const scene::SceneDescription& scene, const scene::Reach& reach,
                 const scene::PlayerSettings& settings)
    : bat_offset_(scene.carried_offset),
      reach_(reach),
      max_acceleration_(settings.max_acceleration),
      max_speed_(settings.max_speed),
      home_(reach.home()) {
  const GameSettings game = game_settings(scene);
  const BallWorld world(scene, game);
  ball_radius_ = game.ball_radius;
  model_ = world.model();
  bat_ = world.bat_law();
  const auto &table = find_surface(scene, "table"), &wall = find_surface(scene, "wall");
  planes_ = {physics::bounce_plane(table.corners, ball_radius_, world.table_law()),
             physics::bounce_plane(wall.corners, ball_radius_, world.wall_law())};
  up_ = planes_[0].normal;
  right_ = (table.corners[1] - table.corners[0]).normalized();
  near_ = right_.cross(up_);
  wall_middle_ = 0.5 * (wall.corners[0] + wall.corners[1]) + ball_radius_ * planes_[1].normal;
  table_middle_ = planes_[0].point;
  home_rotation_ = hold((-near_ + 0.25 * up_).normalized());
  meeting_ = home_ - tip_for(Vector3::Zero(), home_rotation_ * Vector3::UnitY(), home_rotation_);
  choose_return();
}

Quaternion Strokes::hold(const Vector3& normal) const {
  // Bat y = normal; stylus z (away from the blade) as far down as the face allows, then turned about the
  // normal.
  const Vector3 down = (-up_ + up_.dot(normal) * normal).normalized();
  Matrix3 R;
  R.col(1) = normal;
  R.col(2) = down;
  R.col(0) = normal.cross(down);
  return Quaternion(R) * Quaternion(Eigen::AngleAxisd(kTilt, Vector3::UnitY()));
}

Vector3 Strokes::tip_for(const Vector3& ball, const Vector3& normal, const Quaternion& R) const {
  const Vector3 centre = ball - (ball_radius_ + 0.5 * BallWorld::kBatThickness) * normal;
  return centre - R * bat_offset_;
}

Stroke Strokes::stroke_for(const physics::BallState& in, const Vector3& v_out) const {
  // Without friction dv = (1 + e) (u - v.n) n; friction is corrected for by aiming off until the bounce comes
  // out right.
  Stroke stroke;
  Vector3 aim = v_out;
  for (int i = 0; i < 6; ++i) {
    const Vector3 dv = aim - in.velocity;
    stroke.normal = dv.normalized();
    stroke.speed =
        std::clamp(dv.norm() / (1.0 + bat_.restitution) + stroke.normal.dot(in.velocity), 0.1, 1.8);
    const physics::BallState out =
        physics::bounce(model_, in, stroke.normal, bat_, stroke.speed * stroke.normal);
    aim += 0.7 * (v_out - out.velocity);
  }
  return stroke;
}

// Back to the wall: at a place above the table, half way between here and where the ball is wanted back.
// Aims, looks in thought where the ball would go, and aims off.
Stroke Strokes::aim(const physics::BallState& in, double speed, double high, double side) const {
  const Vector3 goal = wall_middle_ + high * up_ +
                       right_.dot(0.5 * (in.position + meeting_) - wall_middle_) * right_ + side * right_;
  const Vector3 way = goal - in.position;
  const double time = std::abs(near_.dot(way)) / speed;
  Vector3 v_out = way / time - 0.5 * time * model_.gravity;
  Stroke stroke;
  for (int i = 0; i < 4; ++i) {
    stroke = stroke_for(in, v_out);
    physics::BallState ball = physics::bounce(model_, in, stroke.normal, bat_, stroke.speed * stroke.normal);
    constexpr double kStep = 0.01, kLongest = 1.0;
    double t = 0.0;
    while (t < kLongest && near_.dot(ball.position - goal) > 0.0) {
      ball = physics::fly(model_, ball, kStep);
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
void Strokes::choose_return() {
  const physics::BallState usual{meeting_, 1.3 * near_ - 0.3 * up_, Vector3::Zero()};
  double best = 1e9;
  for (double speed = 2.0; speed < 3.45; speed += 0.1) {
    for (double height = 0.20; height < 0.50; height += 0.025) {
      const Stroke stroke = aim(usual, speed, height);
      physics::BallState ball =
          physics::bounce(model_, usual, stroke.normal, bat_, stroke.speed * stroke.normal);
      double t = 0.0;
      int table = 0;
      constexpr double kStep = 0.005, kLongest = 2.0;
      bool back = false;
      while (t < kLongest && !(back && near_.dot(ball.position - meeting_) >= 0.0)) {
        const bool away = near_.dot(ball.velocity) < 0.0;
        table += physics::advance(model_, planes_, ball, kStep);
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

std::vector<Meeting> Strokes::meetings(physics::BallState ball, double from, double earliest, double until,
                                       bool bounced) const {
  std::vector<Meeting> places;
  double t = from;
  int bounces = bounced ? 1 : 0;
  bool turned_back = near_.dot(ball.velocity) > 0.0;
  constexpr double kStep = 0.005;
  while (t < until) {
    const bool away = near_.dot(ball.velocity) < 0.0;
    const int n = physics::advance(model_, planes_, ball, kStep);
    t += kStep;
    if (away && near_.dot(ball.velocity) > 0.0) {
      turned_back = true;  // off the wall
      bounces = 0;
    } else if (turned_back) {
      bounces += n;
    }
    if (bounces >= 2) break;
    if (!turned_back || bounces == 0 || t < earliest) continue;
    if (!reach_.contains(ball.position + usual()) || up_.dot(ball.position - table_middle_) < kLowest_m)
      continue;
    places.push_back({t, ball});
  }
  return places;
}

std::optional<Swing> Strokes::swing_to(const Meeting& meeting, double faster, double higher, double right,
                                       const Vector3& miss, const scene::HandState& hand,
                                       const Quaternion& turned, double now) const {
  const Stroke stroke = aim(meeting.ball, faster * return_speed_, higher * return_height_, right);
  const Quaternion R = hold(stroke.normal);
  scene::HandState to;
  to.velocity = stroke.speed * stroke.normal;
  to.position = tip_for(meeting.ball.position, stroke.normal, R) + miss - kSteady_s * to.velocity;
  if (meeting.time - kSteady_s - now < kStep_s) return std::nullopt;
  const scene::Quintic path(hand, to, meeting.time - kSteady_s - now);
  if (path.largest_acceleration() > kAsk * max_acceleration_) return std::nullopt;
  if (path.largest_speed() > max_speed_ || !reach_.contains(path)) return std::nullopt;
  // Room to follow through and to come back.
  scene::HandState after = to;
  after.position += (kSteady_s + kFollow_s) * to.velocity;
  if (!reach_.contains(after.position) || !reach_.contains(way_home(after))) return std::nullopt;
  return Swing{now, meeting.time, true, path, turned, R};
}

std::optional<Swing> Strokes::any_swing_to(const Meeting& meeting, double right, const Vector3& miss,
                                           const scene::HandState& hand, const Quaternion& turned,
                                           double now) const {
  for (const auto& [faster, higher] : kGentler)
    if (auto swing = swing_to(meeting, faster, higher, right, miss, hand, turned, now)) return swing;
  return std::nullopt;
}

// Back to the middle; a little faster or slower where that keeps the arm within its reach.
scene::Quintic Strokes::way_home(const scene::HandState& from) const {
  const scene::HandState home{home_, Vector3::Zero(), Vector3::Zero()};
  // Least jerk: the largest acceleration is about 6 d / T^2, and what is left of the swing must be braked.
  const double d = (home_ - from.position).norm();
  const double T = std::max(
      {kHomeward_s, std::sqrt(8.0 * d / max_acceleration_), 5.0 * from.velocity.norm() / max_acceleration_});
  for (const double share : {1.0, 0.8, 1.25, 0.65}) {
    const scene::Quintic path(from, home, share * T);
    if (path.largest_acceleration() < max_acceleration_ && reach_.contains(path)) return path;
  }
  return {from, home, T};
}

}  // namespace palpate::applications::pingpong
