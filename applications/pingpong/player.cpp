#include "applications/pingpong/player.h"

#include <algorithm>
#include <cmath>

#include "palpate/math/random_vector.h"

namespace palpate::applications::pingpong {
namespace {

constexpr double kCommit_s = 0.08;       // nearer than this to the stroke nothing is changed any more
constexpr double kLeastNotice_s = 0.07;  // a stroke that would have to come sooner is let go
constexpr double kLookAhead_s = 1.6;
constexpr double kSwing_s = 0.22;   // a swing likes to have that much time
constexpr std::size_t kTries = 10;  // places of a flight that are tried for a stroke
constexpr double kWristLead = 2.0;  // what a critically damped wrist lags a steady turn, in 1 / its rate

}  // namespace

ScriptedPlayer::ScriptedPlayer(const scene::SceneDescription& scene, const scene::Reach& reach,
                               const scene::PlayerSettings& settings)
    : settings_(settings),
      strokes_(scene, reach, settings),
      random_(settings.seed, "pingpong/player"),
      hand_(settings.hand, settings.max_acceleration, strokes_.home()) {
  const scene::HandState waits{strokes_.home(), Vector3::Zero(), Vector3::Zero()};
  plan_.path = scene::Quintic(waits, waits, 1.0);
  plan_.rotation_from = plan_.rotation_to = strokes_.home_rotation();
}

void ScriptedPlayer::show(const scene::SceneState& state, Instant<PhysicsClock> displayed) {
  waiting_.push_back({state, displayed + seconds(settings_.reaction_s)});
}

void ScriptedPlayer::notice(const scene::SceneState& state, double now) {
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
  if (state.impact.share > 0.0) return;
  const Vector3 noise =
      normal3(random_, settings_.perception_sd).reverse();  // as it was first drawn: z before x
  const double t = state.time.seconds();
  if (!seen_.empty() && t <= seen_.back().time) return;
  seen_.push_back({t, ball.p() + noise});
  think(now);
}

void ScriptedPlayer::think(double now) {
  if (plan_.stroke && now > plan_.hit - kCommit_s && now < plan_.hit + 0.1) return;
  if (seen_.size() < 3) return;
  const auto fit = physics::fit_flight(strokes_.model(), strokes_.planes(), seen_);
  if (!fit) return;
  // Follow the flight ahead; remember the places within reach, and what each asks of the arm.
  struct Place {
    double cost;
    Meeting meeting;
  };
  std::vector<Place> places;
  const Vector3 usual = strokes_.usual();
  for (const auto& meeting :
       strokes_.meetings(fit->state, fit->time, now + kLeastNotice_s, now + kLookAhead_s)) {
    const double t = meeting.time;
    double cost = (meeting.ball.position + usual - strokes_.home()).norm() +
                  0.03 * std::abs(strokes_.up().dot(meeting.ball.velocity));
    if (t < now + kSwing_s) cost += 0.5 * (now + kSwing_s - t);
    if (plan_.stroke) cost += 0.2 * std::abs(t - plan_.hit);
    places.push_back({cost, meeting});
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.cost < b.cost; });
  // The best place to which there is a way.
  const std::size_t stride = std::max<std::size_t>(1, places.size() / kTries);
  for (std::size_t i = 0; i < places.size(); i += stride)
    if (const auto swing = strokes_.any_swing_to(places[i].meeting, 0.0, aim_error_, plan_.at(now),
                                                 plan_.turned(now), now)) {
      plan_ = *swing;
      return;
    }
  if (plan_.stroke) go_home(now);
}

void ScriptedPlayer::go_home(double now) { go_home(plan_.at(now), plan_.turned(now), now); }

void ScriptedPlayer::go_home(const scene::HandState& from, const Quaternion& turned, double now) {
  const scene::Quintic path = strokes_.way_home(from);
  plan_ = {now, now + path.duration(), false, path, turned, strokes_.home_rotation()};
}

void ScriptedPlayer::take_over(const device::HandTarget& at, Instant<PhysicsClock> now) {
  waiting_.clear();
  seen_.clear();
  started_ = true;
  hand_ = scene::HandTrajectory(settings_.hand, settings_.max_acceleration, at.tip.m, at.velocity);
  go_home({at.tip.m, at.velocity, Vector3::Zero()}, at.R_world_tip, now.seconds());
}

device::HandTarget ScriptedPlayer::act(Instant<PhysicsClock> instant) {
  const double now = instant.seconds();
  if (!started_) {
    started_ = true;
    plan_.begin = now;
    plan_.hit = now;
  }
  while (!waiting_.empty() && waiting_.front().ready <= instant) {
    const scene::SceneState state = waiting_.front().state;
    waiting_.pop_front();
    notice(state, now);
  }
  if (plan_.stroke && now > plan_.hit + Strokes::kFollow_s) go_home(now);

  const scene::HandState& target = hand_.follow(
      now, [this](double t) { return plan_.at(t); }, [this](double t) { return plan_.jerk(t); });
  return {{target.position}, target.velocity, plan_.turned(now + kWristLead / settings_.wrist_rate)};
}

}  // namespace palpate::applications::pingpong
