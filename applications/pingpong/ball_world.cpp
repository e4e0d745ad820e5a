#include "applications/pingpong/ball_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate::applications::pingpong {
namespace {

// Ball on table 0.25 (recorded flights ask for at least 0.23); ball on rubber grips.
// docs/theory/ball-flight.md
constexpr double kTableFriction = 0.25, kBatFriction = 0.6;
// m/s, where Hunt and Crossley's contact has the scene's restitution and duration: half of all rally balls
// are faster. It gives back less of a harder impact.
constexpr double kHuntCrossleySpeed = 5.0;
constexpr int kMostEvents = 12;  // per step; more means the ball is caught between two closing surfaces

// Of ball and bat against each other; the ball's own where the bat is held fast.
double effective_mass_of(const GameSettings& game) {
  if (!(game.bat_mass > game.ball_mass))
    throw std::invalid_argument(
        fmt::format("pingpong: the bat's mass is {} kg, more than the ball's {} kg is expected",
                    game.bat_mass, game.ball_mass));
  return game.ball_mass / (1.0 + game.ball_mass / game.bat_mass);
}

scene::TriangleMesh surface_mesh(const scene::SceneSurface& surface) {
  return {{surface.corners.begin(), surface.corners.end()}, {{0, 1, 2}, {0, 2, 3}}};
}

}  // namespace

const scene::SceneSurface& find_surface(const scene::SceneDescription& scene, const char* name) {
  for (const auto& surface : scene.surfaces) {
    if (surface.name == name) return surface;
  }
  throw std::invalid_argument(std::string("pingpong: the scene has no surface called ") + name);
}

BallWorld::BallWorld(const scene::SceneDescription& scene) : BallWorld(scene, game_settings(scene)) {}

BallWorld::BallWorld(const scene::SceneDescription& scene, const GameSettings& game)
    : model_(game.flight == Flight::paper ? physics::BallModel::paper() : physics::BallModel()),
      law_(effective_mass_of(game), game.bat_restitution, game.contact_s,
           game.contact_model == scene::ContactModel::paper ? physics::Release::where_rest_length_is_back
                                                            : physics::Release::where_force_is_zero),
      course_(law_, 1.0) {
  if (game.contact_model == scene::ContactModel::hunt_crossley)
    stiffening_.emplace(effective_mass_of(game), game.bat_restitution, game.contact_s, kHuntCrossleySpeed);
  model_.radius = game.ball_radius;
  model_.mass = game.ball_mass;
  model_.gravity = scene.gravity;
  const bool rub = game.flight == Flight::full;
  const auto &table = find_surface(scene, "table"), &wall = find_surface(scene, "wall");
  table_bounce_ = {game.surface_restitution, rub ? kTableFriction : 0.0};
  wall_bounce_ = {game.surface_restitution, rub ? kTableFriction : 0.0};
  bat_ = {game.bat_restitution, rub ? kBatFriction : 0.0};
  table_ = physics::CollisionMesh(surface_mesh(table));
  wall_ = physics::CollisionMesh(surface_mesh(wall));
  bat_mesh_ = physics::CollisionMesh(scene::disc_mesh(game.bat_radius, kBatThickness, 32));
}

void BallWorld::place(const physics::BallState& ball) {
  ball_ = ball;
  drawn_ = ball.position;
  contact_.active = false;
}

Vector3 BallWorld::contact_force() const {
  if (!contact_.active) return Vector3::Zero();
  return -course_.force(contact_.elapsed) * contact_.normal_world;
}

void BallWorld::record(const CollisionEvent& touch) {
  if (touch_count_ < touches_.size()) touches_[touch_count_++] = touch;
}

std::optional<physics::SweepHit> BallWorld::sweep_surfaces(const Vector3& from, const Vector3& to,
                                                           Touched& which) const {
  auto best = table_.sweep(from, to, model_.radius);
  which = Touched::table;
  if (auto hit = wall_.sweep(from, to, model_.radius); hit && (!best || hit->fraction < best->fraction)) {
    best = hit;
    which = Touched::wall;
  }
  return best;
}

Vector3 BallWorld::in_bat(double elapsed, double depth) const {
  return contact_.start + elapsed * contact_.slide - depth * contact_.normal;
}

std::span<const CollisionEvent> BallWorld::step(double dt, const BatMotion& bat, bool bat_is_there) {
  touch_count_ = 0;
  double done = 0.0;
  int events = 0;
  if (!bat_is_there) contact_.active = false;
  while (done < dt && events++ < kMostEvents) {
    if (contact_.active) {
      follow(dt, done, bat);
    } else if (!fly_on(dt, done, bat, bat_is_there)) {
      break;
    }
  }
  if (done < dt && events > kMostEvents) {
    ball_.velocity.setZero();  // stays where it is: on the right side of everything
    contact_.active = false;
    record({Touched::squeezed, done, ball_.position, Vector3::Zero()});
  }
  drawn_ = ball_.position;
  if (contact_.active) {
    const double deep = course_.penetration(contact_.elapsed);
    const double shown = kDrawnPenetration * (1.0 - std::exp(-deep / kDrawnPenetration));
    drawn_ += (deep - shown) * contact_.normal_world;
  }
  return {touches_.data(), touch_count_};
}

// Free flight up to the next impact. False when the step is used up.
bool BallWorld::fly_on(double dt, double& done, const BatMotion& bat, bool bat_is_there) {
  const double left = dt - done;
  const physics::BallState next = physics::fly(model_, ball_, left);
  Touched what = Touched::table;
  auto hit = sweep_surfaces(ball_.position, next.position, what);
  if (bat_is_there) {
    const auto on_bat = physics::sweep_moving(bat_mesh_, bat.at(done / dt), bat.after, ball_.position,
                                              next.position, model_.radius);
    if (on_bat && (!hit || on_bat->fraction < hit->fraction)) {
      hit = on_bat;
      what = Touched::bat;
    }
  }
  if (!hit) {
    ball_ = next;
    done = dt;
    return false;
  }
  const Vector3 chord = ball_.position + hit->fraction * (next.position - ball_.position);
  ball_ = physics::fly(model_, ball_, hit->fraction * left);
  ball_.position = chord;  // where the touch was found; the flight is within g dt^2 / 8 of it
  done += hit->fraction * left;
  if (what == Touched::bat) {
    begin_contact(*hit, dt, done, bat);
  } else {
    record({what, done, hit->point, hit->normal, 0.0, 1.0, -hit->normal.dot(ball_.velocity)});
    ball_ =
        physics::bounce(model_, ball_, hit->normal, what == Touched::table ? table_bounce_ : wall_bounce_);
  }
  return true;
}

void BallWorld::begin_contact(const physics::SweepHit& hit, double dt, double done, const BatMotion& bat) {
  const double s = done / dt;
  Vector3 surface = bat.velocity_at(hit.point, s);
  if (-hit.normal.dot(ball_.velocity - surface) <= 0.0) {
    // The measured velocity denies what the places show: take the places.
    const Vector3 local = (bat.at(s).inverse() * Point<World>{hit.point}).m;
    surface = ((bat.after * Point<Bat>{local}).m - (bat.before * Point<Bat>{local}).m) / dt;
  }
  const double approach = -hit.normal.dot(ball_.velocity - surface);
  if (approach <= 1e-6) {  // touching without pressing: pushed along
    ball_.velocity += (1e-3 + approach) * hit.normal;
    return;
  }
  course_ = stiffening_ ? physics::ContactCourse(stiffening_->contact(approach))
                        : physics::ContactCourse(law_, approach);
  // Friction is a share of the impulse, which is the effective mass's.
  const double friction = bat_.friction * (law_.mass() / model_.mass);
  const physics::BallState after =
      physics::bounce(model_, ball_, hit.normal, {course_.restitution(), friction}, surface);
  const auto X_bat_world = bat.at(s).inverse();
  const Vector3 slide = after.velocity - surface - hit.normal.dot(after.velocity - surface) * hit.normal;
  contact_ = {true,
              0.0,
              approach,
              X_bat_world.rotation * hit.normal,
              (X_bat_world * Point<World>{ball_.position}).m,
              X_bat_world.rotation * slide,
              after.spin,
              hit.normal,
              hit.point};
  record({Touched::bat, done, hit.point, hit.normal, course_.duration(), course_.restitution(), approach});
}

// The bat's contact, up to its end, the end of the step, or a second surface in the way.
void BallWorld::follow(double dt, double& done, const BatMotion& bat) {
  const double h = std::min(dt - done, course_.duration() - contact_.elapsed);
  const auto X = bat.at((done + h) / dt);
  const double until = contact_.elapsed + h;
  const Vector3 to = (X * Point<Bat>{in_bat(until, course_.penetration(until))}).m;
  Touched what = Touched::table;
  const auto hit = sweep_surfaces(ball_.position, to, what);
  const double part = hit ? hit->fraction : 1.0;
  const bool ends = !hit && dt - done >= course_.duration() - contact_.elapsed;
  contact_.elapsed += part * h;
  done = ends || hit ? done + part * h : dt;
  const auto X_now = bat.at(std::min(1.0, done / dt));
  contact_.normal_world = X_now.rotation * contact_.normal;
  ball_.position += part * (to - ball_.position);
  contact_.point = ball_.position - model_.radius * contact_.normal_world;
  ball_.spin = contact_.spin;
  const double sinking = ends ? -course_.restitution() * contact_.speed : course_.velocity(contact_.elapsed);
  ball_.velocity = bat.velocity_at(contact_.point, std::min(1.0, done / dt)) +
                   X_now.rotation * contact_.slide - sinking * contact_.normal_world;
  if (hit) {
    contact_.active = false;
    record({Touched::bat_cut_short, done, contact_.point, contact_.normal_world, 0.0, 1.0, contact_.speed});
    record({what, done, hit->point, hit->normal, 0.0, 1.0, -hit->normal.dot(ball_.velocity)});
    ball_ =
        physics::bounce(model_, ball_, hit->normal, what == Touched::table ? table_bounce_ : wall_bounce_);
  } else if (ends) {
    contact_.active = false;
    record({Touched::bat_released, done, contact_.point, contact_.normal_world, 0.0, 1.0, contact_.speed});
  }
}

}  // namespace palpate::applications::pingpong
