#include "palpate/sim/internal/sim_person.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/device/held_places.h"
#include "palpate/math/place_text.h"
#include "palpate/sim/internal/wave.h"
#include "palpate/sim/pose_sampling.h"

namespace palpate::sim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kReachTime = 0.5;   // s from one held pose to the next
constexpr double kSettleTime = 0.3;  // s until a held pose stands still
constexpr double kTouchTime = 0.6;   // s to bring the pointer to the next place
constexpr double kBringTime = 0.8;   // s to bring the stylus where it will be swung
constexpr double kSwingDelay = 0.3;  // s between being there and beginning to swing
constexpr double kSureAngle = 0.9;   // of the largest angle at which LEDs are seen
// How well a person puts the stylus where they are shown: 10 mm and 5 degrees off, rms.
const double kShownPlaceSd = 0.010 / std::sqrt(3.0),
             kShownTurnSd = radians_from_degrees(5.0) / std::sqrt(3.0);
constexpr double kFarOut = 0.10;  // m beyond the arm's reach: nobody tries

// 0 to 1 with zero speed and acceleration at both ends, and its derivative.
double smooth(double s) { return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s); }
double smooth_slope(double s) { return 30.0 * s * s * (1.0 - s) * (1.0 - s); }

}  // namespace

SimPerson::SimPerson(const config::WorldFile& world, const Truth& truth, std::uint64_t seed,
                     SimulatedArm& arm, SimulatedHand& hand)
    : world_(world),
      truth_(truth),
      arm_(arm),
      hand_(hand),
      head_(world, (truth.X_world_board * Point<Board>{{0.100, 0.0625, 0.0}}).m),
      tracker_(middle_of_tracker(world)),
      X_base_world_(truth.X_world_base.inverse()),
      poses_(seed, "person/arm-poses"),
      shown_(seed, "person/shown-poses"),
      touches_(seed, "person/touches"),
      phases_(seed, "person/phases") {
  for (auto& phase : phase_) phase = phases_.uniform(0.0, 2.0 * kPi);
}

Vector3 SimPerson::hand_joints() const { return arm_.theta_of(arm_.state()); }

Quaternion SimPerson::facing_tracker(const Vector3& normal, const Vector3& place) const {
  return facing(normal, (tracker_ - place).normalized());
}

Quaternion SimPerson::swung(const Quaternion& neutral, const Vector3& place, double t, double cone,
                            double roll) const {
  const Vector3 towards = (tracker_ - place).normalized();
  const Vector3 side = towards.unitOrthogonal();
  // Two slow waves of unlike frequency fill the disc of tilts.
  const double radius = 0.5 * (1.0 - std::cos(2.0 * kPi * 0.11 * t)), turn = 2.0 * kPi * 0.63 * t + phase_[0];
  const Vector3 tilt =
      cone * std::sqrt(radius) * (std::cos(turn) * side + std::sin(turn) * towards.cross(side));
  const double ramp = std::min(1.0, t);
  const Quaternion rolled(Eigen::AngleAxisd(ramp * roll * wave(0.17, t, 0.0), towards));
  return (so3_exp(tilt) * rolled * neutral).normalized();
}

void SimPerson::lead(const Vector3& tip, const Vector3& velocity, const Quaternion& orientation) {
  hand_.set_target(arm_.within_reach(tip), velocity, orientation);
}

void SimPerson::follow_path(const JointPath& path, double t, const Quaternion& orientation) {
  const double s = std::clamp((t - path.start) / path.duration, 0.0, 1.0);
  const Vector3 theta = path.from + smooth(s) * (path.to - path.from);
  const Vector3 rate = smooth_slope(s) / path.duration * (path.to - path.from);
  const Vector3 tip = (truth_.X_world_base * device::phantom_tip(theta, truth_.lengths)).m;
  const Vector3 velocity =
      truth_.X_world_base.rotation * (device::phantom_jacobian(theta, truth_.lengths) * rate);
  lead(tip, velocity, orientation);
}

Vector3 SimPerson::wander_joints(double t) const {
  constexpr std::array<double, 3> kHz{0.13, 0.19, 0.23};
  Vector3 theta;
  for (int i = 0; i < 3; ++i) {
    const auto n = static_cast<std::size_t>(i);
    const auto& [low, high] = world_.arm.joint_range[n];
    theta[i] = 0.5 * (low + high) + 0.45 * (high - low) * wave(kHz[n], t, phase_[n]);
  }
  return theta;
}

void SimPerson::begin_pose_of_their_own() {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    path_ = {hand_joints(), random_joints(world_, poses_).value_or(hand_joints()), now_, kReachTime};
    const Vector3 tip = (truth_.X_world_base * device::phantom_tip(path_.to, truth_.lengths)).m;
    const Quaternion marker =
        random_orientation(tip_marker_normal(), (tracker_ - tip).normalized(), kAnyRoll, poses_);
    held_orientation_ = marker * truth_.X_tip_marker.rotation.conjugate();
    const Vector3 gimbal = device::phantom_gimbal(path_.to, X_base_world_.rotation * held_orientation_);
    if (std::abs(gimbal[1]) < kGimbalReach) break;
  }
}

// As near to what is shown as hand, joints and gimbal allow.
Expected<void> SimPerson::begin_shown_pose(const device::PoseTarget& target) {
  const Vector3 miss(shown_.normal(kShownPlaceSd), shown_.normal(kShownPlaceSd),
                     shown_.normal(kShownPlaceSd));
  const Vector3 turn(shown_.normal(kShownTurnSd), shown_.normal(kShownTurnSd), shown_.normal(kShownTurnSd));
  if (!target.tip.m.allFinite() || !target.R_world_marker.coeffs().allFinite())
    return refused("next pose: the place that is shown is not a number");
  const Vector3 tip = arm_.within_reach(target.tip.m + miss);
  Vector3 theta;
  if ((tip - target.tip.m - miss).norm() > kFarOut ||
      !device::phantom_inverse(X_base_world_ * Point<World>{tip}, truth_.lengths, theta))
    return refused(ErrorCode::out_of_reach, "next pose: {} is out of the arm's reach; show a nearer place",
                   place_text_mm(target.tip.m, 0));
  const Quaternion marker = so3_exp(turn) * target.R_world_marker.normalized();
  Vector3 gimbal = device::phantom_gimbal(
      theta, X_base_world_.rotation * marker * truth_.X_tip_marker.rotation.conjugate());
  gimbal[1] = std::clamp(gimbal[1], -kGimbalReach, kGimbalReach);
  path_ = {hand_joints(), theta, now_, kReachTime};
  held_orientation_ = (truth_.X_world_base.rotation * device::phantom_stylus(theta, gimbal)).normalized();
  return {};
}

// As Gesture::hold has it; the middle where the arm does not reach so far.
Vector3 SimPerson::held_joints(int index) const {
  const Vector3 middle = middle_joints(world_);
  if (index <= 0 || index >= static_cast<int>(device::kHeldPlaces.size())) return middle;
  const Vector3 tip = (truth_.X_world_base * device::phantom_tip(middle, truth_.lengths)).m +
                      device::kHeldPlaces[static_cast<std::size_t>(index)];
  Vector3 theta;
  return device::phantom_inverse(X_base_world_ * Point<World>{arm_.within_reach(tip)}, truth_.lengths, theta)
             ? theta
             : middle;
}

Expected<void> SimPerson::begin_touch(const device::Request& request) {
  Vector3 place, front;
  const auto corner = [&](const config::Corners& corners) {
    place = corners[static_cast<std::size_t>(request.index)];
    front = (corners[1] - corners[0]).cross(corners[3] - corners[0]).normalized();
  };
  const bool surface = request.what == "table" || request.what == "wall";
  const int count = surface ? 4 : request.what == "landmark" ? static_cast<int>(truth_.landmarks.size()) : 0;
  if (request.index < 0 || request.index >= count)
    return refused(ErrorCode::no_more,
                   "touch {} {}: the laboratory has table 0-3, wall 0-3 and landmark 0-{}", request.what,
                   request.index, static_cast<int>(truth_.landmarks.size()) - 1);
  if (request.what == "table") corner(truth_.table);
  if (request.what == "wall") corner(truth_.wall);
  if (request.what == "landmark") {
    place = truth_.landmarks[static_cast<std::size_t>(request.index)].centre;
    front = truth_.landmarks[static_cast<std::size_t>(request.index)].normal;
  }
  const double sd = world_.pointer.touch_sd;
  const Vector3 miss(touches_.normal(sd), touches_.normal(sd), touches_.normal(sd));
  // Held off the surface as far as the tracker still sees it.
  Vector3 shine;
  for (double off = 0.9; off >= 0.0; off -= 0.1) {
    shine = ((tracker_ - place).normalized() + off * front).normalized();
    const Vector3 body = place + truth_.pointer_tip.norm() * shine;
    double largest = 0.0;
    for (const auto& camera : world_.tracker.cameras)
      largest = std::max(largest, std::acos(std::clamp(shine.dot((camera - body).normalized()), -1.0, 1.0)));
    if (largest < kSureAngle * world_.tracker.max_led_angle) break;
  }
  pointer_from_ = pointer_to_;
  pointer_to_ = PointerPlace{place + miss, rotation_between(pointer_normal(), shine)};
  if (!pointer_from_) pointer_from_ = pointer_to_;
  return {};
}

Expected<void> SimPerson::ask(const device::Request& request) {
  if (request.gesture == device::Gesture::touch) {
    if (const auto done = begin_touch(request); !done) return done;
  }
  if (request.gesture == device::Gesture::next_pose && request.target) {
    if (const auto done = begin_shown_pose(*request.target); !done) return done;
  }
  const double t = now_;
  const bool needs_stylus =
      request.gesture == device::Gesture::next_pose || request.gesture == device::Gesture::swing_stylus ||
      request.gesture == device::Gesture::wander || request.gesture == device::Gesture::rest ||
      request.gesture == device::Gesture::hold;
  if (needs_stylus && !(request.gesture == device::Gesture::rest && hand_.grip() == Grip::none))
    hand_.take(Grip::follow, arm_.state().tip, arm_.state().velocity);
  if (!needs_stylus && hand_.grip() == Grip::swing)
    hand_.take(Grip::follow, arm_.state().tip, arm_.state().velocity);
  playing_ = false;
  in_hollow_ = request.gesture == device::Gesture::swing_stylus && request.what == "hollow";
  arm_.rest_in(std::nullopt);
  gesture_ = request.gesture;
  began_ = t;
  switch (request.gesture) {
    case device::Gesture::next_pose:
      if (!request.target) begin_pose_of_their_own();
      break;
    case device::Gesture::swing_stylus: {
      const Vector3 middle = middle_joints(world_);
      path_ = {hand_joints(), middle, t, kBringTime};
      const Vector3 tip = (truth_.X_world_base * device::phantom_tip(middle, truth_.lengths)).m;
      neutral_ = facing_tracker(tip_marker_normal(), tip);
      held_orientation_ = neutral_ * truth_.X_tip_marker.rotation.conjugate();
      break;
    }
    case device::Gesture::rest:
      path_ = {hand_joints(), Vector3::Zero(), t, kReachTime};
      held_orientation_ = truth_.X_world_base.rotation;
      pointer_from_.reset();
      pointer_to_.reset();
      break;
    case device::Gesture::hold:
      path_ = {hand_joints(), held_joints(request.index), t, kReachTime};
      held_orientation_ = arm_.state().orientation;
      break;
    case device::Gesture::swing_pointer: {
      const Vector3 across = truth_.table[1] - truth_.table[0], along = truth_.table[3] - truth_.table[0];
      const Vector3 divot = truth_.table[0] + 0.75 * across + 0.5 * along;
      pointer_to_ = PointerPlace{divot, facing_tracker(pointer_normal(), divot)};
      pointer_from_ = pointer_to_;
      break;
    }
    case device::Gesture::look_around_board:
      head_.look_around_board(t);
      break;
    case device::Gesture::look:
      head_.look(t);
      break;
    case device::Gesture::wander:
      path_ = {hand_joints(), hand_joints(), t, 1.0};
      break;
    case device::Gesture::touch:
      break;
  }
  if (request.gesture != device::Gesture::look_around_board) head_.look(t);
  return {};
}

bool SimPerson::there() const {
  const double t = now_ - began_;
  switch (gesture_) {
    case device::Gesture::next_pose:
    case device::Gesture::rest:
    case device::Gesture::hold:
      return t > kReachTime + kSettleTime && arm_.state().velocity.norm() < 1e-3;
    case device::Gesture::swing_stylus:
      return t > kBringTime + 0.1;
    case device::Gesture::wander:
      return t > 1.5;
    case device::Gesture::swing_pointer:
      return t > 1.0;
    case device::Gesture::touch:
      return t > kTouchTime + kSettleTime;
    case device::Gesture::look_around_board:
    case device::Gesture::look:
      return head_.settled(now_);
  }
  return false;
}

void SimPerson::play(const device::HandTarget& target, double t) {
  if (!playing_) {
    arm_.rest_in(std::nullopt);
    hand_.take(Grip::follow, arm_.state().tip, arm_.state().velocity);
    gesture_ = device::Gesture::look;
    head_.look(t);
    playing_ = true;
  }
  head_.hold_still(target.head_still, t);
  played_ = target;
  played_at_ = t;
}

// Held by the arm the tip is pulled at; in a hollow, which stands where the arm is in the middle of its range, it is
// pressed into it.
void SimPerson::swing_stylus(double t) {
  const double since = t - began_, swing = since - (kBringTime + kSwingDelay);
  if (swing < 0.0) {
    follow_path(path_, t, held_orientation_);
    return;
  }
  if (hand_.grip() != Grip::swing) {
    hand_.take(Grip::swing, arm_.state().tip, arm_.state().velocity);
    if (in_hollow_) arm_.rest_in((truth_.X_world_base * device::phantom_tip(path_.to, truth_.lengths)).m);
  }
  const Vector3 tip = arm_.state().tip;
  const Quaternion marker = swung(neutral_, tip, swing, kMarkerTilt, kSwingRoll);
  hand_.set_target(tip, Vector3::Zero(), marker * truth_.X_tip_marker.rotation.conjugate());
  const auto& [low, high] = world_.hand.pull;
  const double size = low + (high - low) * 0.5 * (1.0 + wave(0.37, t, phase_[3]));
  const Quaternion& stylus = arm_.state().orientation;
  const Vector3 way = in_hollow_ ? Vector3(stylus * -Vector3::UnitZ()) : pull_direction(stylus);
  hand_.set_pull(std::min(1.0, since) * size * way);
}

void SimPerson::update(double t) {
  now_ = t;
  if (playing_) {
    // A target is carried on with its velocity until it is clearly stale.
    const double age = t - played_at_;
    const bool fresh = age < 0.1;
    lead(played_.tip.m + std::min(age, 0.1) * played_.velocity, fresh ? played_.velocity : Vector3::Zero(),
         played_.R_world_tip);
    return;
  }
  const double since = t - began_;
  switch (gesture_) {
    case device::Gesture::next_pose:
    case device::Gesture::hold:
      follow_path(path_, t, held_orientation_);
      break;
    case device::Gesture::rest:
      if (hand_.grip() == Grip::none) break;
      follow_path(path_, t, held_orientation_);
      if (there()) hand_.take(Grip::none, arm_.state().tip, arm_.state().velocity);
      break;
    case device::Gesture::swing_stylus:
      swing_stylus(t);
      break;
    case device::Gesture::wander: {
      const double share = smooth(std::clamp(since, 0.0, 1.0));
      const double step = 1e-3;
      const auto place = [&](double when) {
        const Vector3 theta = path_.from + share * (wander_joints(when) - path_.from);
        return Vector3(
            arm_.within_reach((truth_.X_world_base * device::phantom_tip(theta, truth_.lengths)).m));
      };
      const Vector3 tip = place(t), velocity = (place(t + step) - tip) / step;
      const Quaternion marker =
          swung(facing_tracker(tip_marker_normal(), tip), tip, since, kMarkerTilt, kSwingRoll);
      lead(tip, velocity, marker * truth_.X_tip_marker.rotation.conjugate());
      break;
    }
    case device::Gesture::touch:
    case device::Gesture::swing_pointer:
    case device::Gesture::look_around_board:
    case device::Gesture::look:
      break;
  }
}

std::optional<Pose<World, Pointer>> SimPerson::pointer(double t) const {
  if (!pointer_to_ || (gesture_ != device::Gesture::touch && gesture_ != device::Gesture::swing_pointer))
    return std::nullopt;
  const double since = t - began_;
  PointerPlace place = *pointer_to_;
  if (gesture_ == device::Gesture::touch) {
    const double s = smooth(std::clamp(since / kTouchTime, 0.0, 1.0));
    place.tip = pointer_from_->tip + s * (pointer_to_->tip - pointer_from_->tip);
    place.rotation = pointer_from_->rotation.slerp(s, pointer_to_->rotation);
  } else {
    place.rotation = swung(place.rotation, place.tip, std::max(0.0, since - 0.5), kMarkerTilt, kSwingRoll);
  }
  return Pose<World, Pointer>{place.rotation, place.tip - place.rotation * truth_.pointer_tip};
}

}  // namespace palpate::sim
