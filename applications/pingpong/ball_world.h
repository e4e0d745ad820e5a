// The ball among the real table and wall and the moving bat: flight, impacts, and the bat's contact that
// lasts.
//
// Table and wall answer at once. The bat's contact is followed in the bat's frame: the ball sinks in along
// the normal of the touch as the damped mass on a spring does that the scene asks for, slides as friction
// leaves it, and is released with the restitution exact relative to the bat as it then moves. A second
// surface met during the contact ends it there. Gravity is left out during those few milliseconds. A
// bat of stated mass M recoils: ball m and bat move against each other as the effective mass m M / (m + M),
// in the ball's leap as in the hand's impact. World frame, SI. step() allocates, locks and throws nothing.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "applications/pingpong/settings.h"
#include "palpate/physics/ball.h"
#include "palpate/physics/contact_course.h"
#include "palpate/physics/sweep.h"
#include "palpate/scene/application.h"

namespace palpate::applications::pingpong {

enum class Touched : std::uint8_t { table, wall, bat, bat_released, bat_cut_short, squeezed };

struct CollisionEvent {
  Touched what = Touched::table;
  double at = 0.0;  // s after the start of the step
  Vector3 point = Vector3::Zero();
  Vector3 normal = Vector3::Zero();          // towards the ball
  double duration = 0.0, restitution = 1.0;  // of a bat's contact that begins
  double approach_speed = 0.0;               // along the normal, relative
};

struct BatMotion {  // over one step
  Pose<World, Bat> before, after;
  Vector3 velocity = Vector3::Zero();  // of the bat frame's origin
  Vector3 angular_velocity = Vector3::Zero();

  Pose<World, Bat> at(double s) const {
    return s <= 0.0 ? before : s >= 1.0 ? after : interpolate(before, after, s);
  }
  Vector3 velocity_at(const Vector3& point, double s) const {
    return velocity + angular_velocity.cross(point - at(s).translation);
  }
};

class BallWorld {
 public:
  static constexpr double kBatThickness = 0.012;  // m: blade and two rubbers
  static constexpr double kDrawnPenetration =
      0.003;  // m, at most, so that the ball never seems to dive into the bat

  // Throws std::invalid_argument where the scene has no surface called "table" and "wall", its payload is not
  // the game's, or the bat is not of a mass above the ball's.
  explicit BallWorld(const scene::SceneDescription& scene);
  BallWorld(const scene::SceneDescription& scene, const GameSettings& game);

  // What was touched, in order; valid until the next step.
  std::span<const CollisionEvent> step(double dt, const BatMotion& bat, bool bat_is_there = true);
  void place(const physics::BallState& ball);  // ends a contact

  const physics::BallState& ball() const { return ball_; }
  // Where to draw the ball: during a contact not deeper in the bat than kDrawnPenetration.
  Vector3 drawn_position() const { return drawn_; }
  bool in_contact() const { return contact_.active; }
  double contact_progress() const { return contact_.active ? contact_.elapsed / course_.duration() : 0.0; }
  Vector3 contact_force() const;  // on the hand, N, as the model has it now
  Vector3 contact_point() const { return contact_.point; }
  double effective_mass() const { return law_.mass(); }  // of an impact on the bat, kg
  const physics::BallModel& model() const { return model_; }
  physics::Bounce bat_law() const { return bat_; }
  physics::Bounce table_law() const { return table_bounce_; }
  physics::Bounce wall_law() const { return wall_bounce_; }

 private:
  struct Contact {
    bool active = false;
    double elapsed = 0.0, speed = 0.0;
    Vector3 normal = Vector3::Zero(), start = Vector3::Zero(), slide = Vector3::Zero();  // Bat frame
    Vector3 spin = Vector3::Zero();
    Vector3 normal_world = Vector3::Zero(), point = Vector3::Zero();  // as of now
  };
  void record(const CollisionEvent& touch);
  bool fly_on(double dt, double& done, const BatMotion& bat, bool bat_is_there);
  void follow(double dt, double& done, const BatMotion& bat);
  void begin_contact(const physics::SweepHit& hit, double dt, double done, const BatMotion& bat);
  Vector3 in_bat(double elapsed, double depth) const;
  std::optional<physics::SweepHit> sweep_surfaces(const Vector3& from, const Vector3& to,
                                                  Touched& which) const;

  physics::BallModel model_;
  physics::Bounce table_bounce_, wall_bounce_, bat_;
  physics::CollisionMesh table_, wall_, bat_mesh_;
  physics::DampedContact law_;  // linear in the speed: for 1 m/s
  std::optional<physics::HuntCrossley> stiffening_;
  physics::ContactCourse course_;  // of the contact there is, or was
  physics::BallState ball_;
  Vector3 drawn_ = Vector3::Zero();
  Contact contact_;
  std::array<CollisionEvent, 16> touches_;
  std::size_t touch_count_ = 0;
};

const scene::SceneSurface& find_surface(const scene::SceneDescription& scene, const char* name);

}  // namespace palpate::applications::pingpong
