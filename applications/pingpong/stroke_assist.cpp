#include "applications/pingpong/stroke_assist.h"

#include <algorithm>
#include <vector>

#include "applications/pingpong/pingpong.h"

namespace palpate::applications::pingpong {
namespace {

constexpr double kLeast_s = 0.07;      // a stroke that would have to come sooner is left to the pointer
constexpr double kSwingTime_s = 0.33;  // a stroke begins that long before its hit
constexpr double kLooked_s = 0.45;     // so far ahead the best place is looked for
constexpr double kFixed_s = 0.08;      // nearer than this to the hit nothing is changed any more
constexpr double kThink_s = 0.01;      // between two thoughts, where no news come
constexpr double kHoldOn = 1.5;        // times the capture, until a stroke that has begun is called off
constexpr double kOld_s = 0.35;        // a state shown longer ago tells nothing of a ball
constexpr double kStrokeLead = 2.0;    // what a critically damped wrist lags a steady turn, in 1 / its rate
constexpr std::size_t kMostTries = 8;

bool flies(const scene::SceneState& state) {
  const auto phase = static_cast<Phase>(state.counters[kPhase]);
  return state.bodies[kBall].visible != 0 && (phase == Phase::incoming || phase == Phase::outgoing);
}

double off_the_ray(const Vector3& place, const scene::Led& led) {
  const Vector3 way = place - led.eye;
  return (way - way.dot(led.ray) * led.ray).norm();
}

}  // namespace

StrokeAssist::StrokeAssist(const scene::SceneDescription& scene, const scene::Reach& reach,
                           const scene::PlayerSettings& settings)
    : settings_(settings),
      strokes_(scene, reach, settings),
      random_(settings.seed, "pingpong/stroke help"),
      hand_(settings.hand, settings.max_acceleration, strokes_.home()) {}

void StrokeAssist::show(const scene::SceneState& state) {
  if (shown_ && state.time <= shown_->time) return;
  const auto changed = [&](Counter c) { return !shown_ || shown_->counters[c] != state.counters[c]; };
  // What it touched between two pictures it touched after it came: wall and bat are far from the table's
  // middle.
  if (changed(kServes) || changed(kWallBounces) || changed(kHits))
    bounces_before_ =
        shown_ && !changed(kServes) ? shown_->counters[kTableBounces] : state.counters[kTableBounces];
  shown_ = state;
  news_ = true;
}

std::vector<Meeting> StrokeAssist::places(double now, const scene::Led& led) const {
  if (!shown_ || !flies(*shown_) || shown_->impact.share > 0.0) return {};
  const double seen = shown_->time.seconds();
  if (now - seen > kOld_s) return {};
  const auto& body = shown_->bodies[kBall];
  const bool bounced = shown_->counters[kTableBounces] > bounces_before_;
  struct Place {
    double cost;
    Meeting meeting;
  };
  std::vector<Place> found;
  const double capture = swing_ ? kHoldOn * kCapture_m : kCapture_m;
  for (const auto& meeting : strokes_.meetings({body.p(), body.v(), Vector3(body.angular_velocity.data())},
                                               seen, now + kLeast_s, now + kLooked_s, bounced)) {
    const double off = off_the_ray(meeting.ball.position, led);
    if (off > capture) continue;
    const double from_home = (meeting.ball.position + strokes_.usual() - strokes_.home()).norm();
    double cost = 0.5 * off + from_home + 0.03 * std::abs(strokes_.up().dot(meeting.ball.velocity));
    if (swing_) cost += 0.3 * std::abs(meeting.time - swing_->hit);
    found.push_back({cost, meeting});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Place& a, const Place& b) { return a.cost < b.cost; });
  std::vector<Meeting> result;
  for (const auto& place : found) result.push_back(place.meeting);
  return result;
}

void StrokeAssist::think(double now, const scene::Led& led) {
  const auto meetings = places(now, led);
  if (meetings.empty()) return swing_.reset();
  if (!swing_ && meetings.front().time - now > kSwingTime_s) return;
  if (!swing_) varied_ = random_.uniform(-kVaried_m, kVaried_m);
  const scene::HandState hand =
      swing_ ? swing_->at(now) : scene::HandState{led.hand.tip.m, led.hand.velocity, Vector3::Zero()};
  const Quaternion turned = swing_ ? swing_->turned(now) : led.hand.R_world_tip;
  const std::size_t stride = std::max<std::size_t>(1, meetings.size() / kMostTries);
  for (std::size_t i = 0; i < meetings.size(); i += stride) {
    const auto swing =
        strokes_.any_swing_to(meetings[i], led.side * kAside_m + varied_, Vector3::Zero(), hand, turned, now);
    if (!swing) continue;
    if (!swing_)
      hand_ = scene::HandTrajectory(settings_.hand, settings_.max_acceleration, hand.position, hand.velocity);
    swing_ = swing;
    return;
  }
  // No better way: a stroke that has begun goes on as it was meant.
}

std::optional<device::HandTarget> StrokeAssist::act(Instant<PhysicsClock> instant, const scene::Led& led) {
  const double now = instant.seconds();
  if (swing_ && now > swing_->hit + Strokes::kFollow_s) swing_.reset();
  const bool fixed = swing_ && now > swing_->hit - kFixed_s;
  if (!fixed && (news_ || now - thought_ > kThink_s || now < thought_)) {
    news_ = false;
    thought_ = now;
    think(now, led);
  }
  if (!swing_) return std::nullopt;
  const scene::HandState& target = hand_.follow(
      now, [this](double t) { return swing_->at(t); }, [this](double t) { return swing_->jerk(t); });
  return device::HandTarget{
      {target.position}, target.velocity, swing_->turned(now + kStrokeLead / settings_.wrist_rate)};
}

}  // namespace palpate::applications::pingpong
