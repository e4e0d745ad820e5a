#include "palpate/physics/tissue/tissue_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "palpate/physics/tissue/two_contacts.h"
#include "palpate/scene/carry_on.h"

namespace palpate::physics::tissue {
namespace {

constexpr double kShortestTick = 1e-4, kLongestTick = 0.02;  // s

const TipField& checked_field(const TipField& field) {
  if (const auto good = TissueLaw::renders(field); !good) throw std::invalid_argument(good.error().message);
  return field;
}

double checked_damping(double damping) {
  if (!(damping >= 0.0 && damping <= 10.0))
    throw std::invalid_argument(
        fmt::format("tissue: passivity damping {} N s/m; 0 to 10 is expected", damping));
  return damping;
}

double checked_young(double young) {
  if (!(young >= 100.0 && young <= 1e9))
    throw std::invalid_argument(fmt::format("tissue: Young's modulus {} Pa; 100 to 1e9 is expected", young));
  return young;
}

}  // namespace

Expected<void> TissueLaw::renders(const TipField& field) {
  const TipFieldFacts& facts = field.facts();
  if (facts.stiffest_n_m > kMostTangent_n_m)
    return refused(
        "tissue: {:.0f} N/m stiff where it is stiffest; at most {:.0f} can be rendered without buzzing: "
        "choose "
        "a softer material, a smaller tip or less depth",
        facts.stiffest_n_m, kMostTangent_n_m);
  if (facts.strongest_n > kBound_n)
    return refused(
        "tissue: a force of {:.1f} N where it is strongest; at most {:.0f} is allowed: choose a softer "
        "material or less depth",
        facts.strongest_n, kBound_n);
  return {};
}

TissueLaw::TissueLaw(const TipField& field, const TissueSettings& settings, const Pose<World, Body>& rest)
    : field_(checked_field(field)),
      dissipation_(settings.dissipation),
      account_(checked_damping(settings.passivity_damping_n_s_m)),
      passivity_damping_(settings.passivity_damping_n_s_m),
      finger_(settings.finger),
      young_(checked_young(settings.young_pa)),
      poisson_(settings.dissipation.poisson) {
  body_.X_world_body = rest;
}

// At once, and all that was remembered is forgotten.
void TissueLaw::disengage() {
  touch_.created_j += account_.created();
  touch_.engaged = touch_.releasing = false;
  touch_.contact = TipEnergy{};
  finger_before_there_ = false;
  held_.setZero();
  dissipation_.reset();
  account_.reset();
}

// What it held fades.
void TissueLaw::let_go() {
  left_j_ = 0.5 * touch_.contact.energy;
  const Vector3 held = held_;
  disengage();
  held_ = held_earlier_ = held;
  touch_.releasing = !held.isZero(0.0);
  ++touch_.lost;
}

// With a finger at this place: the tip's force, and the energy beyond what the finger alone stores.
TipEnergy TissueLaw::shared(const TipEnergy& alone, const Vector3& p, const Vector3& finger) {
  const MutualCompliance mutual =
      half_space_compliance(p, finger, young_, poisson_, finger_->facts().tip_radius);
  const TwoForces both = two_contacts(field_, p, *finger_, finger, mutual);
  TipEnergy now = alone;
  now.force = both.first;
  now.energy = both.energy - finger_->at(finger).energy;
  touch_.finger_force = both.second;
  return now;
}

void TissueLaw::meet_finger(TipEnergy& now, const Vector3& p) {
  const bool there = finger_ != nullptr && body_.finger_there && body_.finger.allFinite();
  if (!there && !finger_before_there_) return;
  const TipEnergy alone = now;
  // What the tip's part of the energy gains because the finger moves is the finger's work.
  const double before = finger_before_there_ ? shared(alone, p, finger_before_).energy : alone.energy;
  touch_.finger_force.setZero();
  if (there) now = shared(alone, p, body_.finger);
  account_.credit(now.energy - before);
  finger_before_there_ = there;
  if (there) finger_before_ = body_.finger;
}

// Whether the force at this place still pushes to where the tip came from.
bool TissueLaw::still_on_its_side(const TipEnergy& now, const Vector3& moved) const {
  if (now.depth <= 0.0) return true;
  if (now.lost || now.normal.isZero(0.0)) return false;
  if (touch_.contact.depth > 0.0) return now.normal.dot(touch_.contact.normal) > 0.0;
  // It has come in within this tick: from the other side where it would be pushed on the way it goes.
  return now.normal.dot(moved) < 0.5 * moved.norm();
}

Vector3 TissueLaw::press(const TipEnergy& now, const Vector3& moved, const Vector3& velocity, double dt) {
  account_.moved(moved);
  Vector3 force = now.force + dissipation_.step(now, moved, dt);
  touch_.damping =
      passivity_damping_ > 0.0 ? account_.damping(now.energy + dissipation_.stored(), velocity, dt) : 0.0;
  Vector3 damper = -touch_.damping * velocity;
  // Nor does it make the contact stick.
  const double along = now.normal.dot(damper), pressed = std::max(0.0, now.normal.dot(force));
  if (along < -pressed) damper += (-pressed - along) * now.normal;
  force += damper;
  if (const double size = force.norm(); size > kBound_n) force *= kBound_n / size;
  account_.give(force);
  touch_.damped_ticks += touch_.damping > 0.0;
  return force;
}

// What is left of the force of a tip that was let go.
Vector3 TissueLaw::release(const Vector3& moved, double dt) {
  left_j_ -= std::max({0.0, held_.dot(moved), held_earlier_.dot(moved)});
  held_earlier_ = held_;
  const double size = held_.norm(), next = size - kRelease_n_s * dt;
  if (next <= 0.0 || left_j_ <= 0.0) {
    touch_.releasing = false;
    return Vector3::Zero();
  }
  return held_ * (next / size);
}

void TissueLaw::follow(const scene::TipState& tip, double dt) {
  const Vector3 place = tip.X_world_tip.translation;
  const bool seen = place.allFinite() && tip.velocity.allFinite() && place.norm() < 1e6;
  const Pose<World, Body> X_world_body = scene::carried_on(body_.X_world_body, body_, tip.time);
  const auto X_body_world = X_world_body.inverse();
  const Vector3 p = seen ? (X_body_world * Point<World>{place}).m : place_before_;
  const bool jumped = !seen || !seen_before_ || (place - tip_before_).norm() > kTeleport_m ||
                      (p - place_before_).norm() > kTeleport_m;
  const Vector3 moved = p - place_before_;
  seen_before_ = seen;
  if (seen) tip_before_ = place;
  if (seen) place_before_ = p;

  touch_.force.setZero();
  touch_.static_force.setZero();
  touch_.finger_force.setZero();
  touch_.damping = 0.0;
  if (jumped || body_.paused) disengage();
  if (!seen || body_.paused) return;
  TipEnergy now = field_.at(p);
  if (!touch_.engaged && now.depth <= 0.0) touch_.engaged = true;
  if (touch_.engaged && !still_on_its_side(now, moved)) let_go();
  if (touch_.releasing) {
    held_ = release(moved, dt);
    touch_.force = X_world_body.rotation * held_;
    return;
  }
  if (!touch_.engaged) return;
  const bool touched = touch_.contact.depth > 0.0, slid = dissipation_.sliding();
  if (now.depth <= 0.0) {
    if (touched) disengage();
    touch_.engaged = true;
    return;
  }
  meet_finger(now, p);
  const Vector3 lever = place - X_world_body.translation;
  const Vector3 relative = tip.velocity - body_.velocity - body_.spin.cross(lever);
  held_ = press(now, moved, X_body_world.rotation * relative, dt);
  touch_.contact = now;
  touch_.force = X_world_body.rotation * held_;
  touch_.static_force = X_world_body.rotation * now.force;
  touch_.finger_force = X_world_body.rotation * touch_.finger_force;
  touch_.touches += !touched;
  touch_.contact_s += dt;
  touch_.slips += touched && dissipation_.sliding() && !slid;
}

Vector3 TissueLaw::force(const scene::TipState& tip, double dt) noexcept {
  motion_.read(body_);
  if (body_.resets != touch_.resets) {
    touch_.touches = touch_.slips = touch_.lost = touch_.damped_ticks = 0;
    touch_.contact_s = touch_.peak_n = touch_.created_j = 0.0;
    touch_.resets = body_.resets;
  }
  follow(tip, std::isfinite(dt) ? std::clamp(dt, kShortestTick, kLongestTick) : kLongestTick);
  touch_.tip = tip_before_;
  touch_.peak_n = std::max(touch_.peak_n, touch_.force.norm());
  found_.write(touch_);
  return touch_.force;
}

}  // namespace palpate::physics::tissue
