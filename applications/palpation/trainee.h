// The scripted trainee of palpation (palpate/scene/player.h): presses place after place of a grid to one depth, compares
// what it feels, presses where a nodule is likeliest by then, marks where it believes one to be, and puts the stylus away.
// When the next trial begins, it searches again.
//
// It feels through the commanded force alone, as late as everything it is shown, and remembers it with the noise of a
// Weber fraction (experiment/observer.h): all of its imprecision is in there, as in the thresholds published, so that the
// depth of a press is taken as shown. It knows the surface at rest, where it lies, its own arm and the rules, never the
// truth. Without its sense every press feels alike but for the noise. One thread; deterministic for a seed.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "applications/palpation/liver.h"
#include "applications/palpation/press_map.h"
#include "applications/palpation/settings.h"
#include "palpate/experiment/observer.h"
#include "palpate/physics/sweep.h"
#include "palpate/scene/player.h"

namespace palpate::applications::palpation {

class Trainee : public scene::Player {
 public:
  Trainee(const scene::SceneDescription& scene, const scene::Reach& reach,
          const scene::PlayerSettings& settings);

  void show(const scene::SceneState& state, Instant<PhysicsClock> displayed) override;
  device::HandTarget act(Instant<PhysicsClock> now) override;
  void take_over(const device::HandTarget& at, Instant<PhysicsClock> now) override;

  const PressMap& map() const { return map_; }
  bool done() const { return doing_ == Doing::resting; }

 private:
  enum class Doing { coming, crossing, pressing, holding, rising, thinking, leaving, resting };
  struct Shown {
    scene::SceneState state;
    Instant<PhysicsClock> ready;
  };
  struct Press {  // what has been seen of one
    std::size_t place = 0;
    double from = 0.0, to = 0.0;  // s, of the states that show it
    double sum = 0.0, depth = 0.0, slowest = 1e9;
    int count = 0;
  };
  struct Spot {  // of the surface, Body
    Vector3 place, normal;
  };

  std::vector<PlanPlace> places_in_reach(const scene::SceneDescription& scene) const;
  PressMap empty_map() const;
  void plan_grid();
  bool begins_again(const scene::SceneState& state);
  void forget();
  std::optional<Spot> spot_at(const PlanPlace& place) const;
  bool can_press(const PlanPlace& place) const;
  Vector3 over(const Spot& spot, double height) const;  // World; below 0: pressed
  void notice(const scene::SceneState& state);
  void feel(const scene::SceneState& state, Press& press) const;
  void learn(const Press& press);
  bool time_is_short(double now) const;
  void hold(double now);
  void go(double now, const Vector3& to, double duration);
  void next(double now);
  void look_closer();
  void after_thinking(double now);
  void approach(double now, const PlanPlace& place);

  PalpationSettings palpation_;
  scene::Reach reach_;
  scene::PlayerSettings settings_;
  Pose<World, Body> X_world_body_;
  scene::TriangleMesh surface_;
  std::vector<Vector3> normals_;
  physics::CollisionMesh mesh_;
  double top_ = 0.0;  // m
  double weber_;
  experiment::Observer observer_;
  std::vector<PlanPlace> grid_;
  PressMap map_;
  std::deque<Shown> waiting_;
  std::deque<Press> presses_;
  std::vector<std::size_t> queue_;  // places still to be pressed, the last one first
  std::vector<PlanPlace> to_mark_;
  std::vector<int> tries_;  // of each place, in vain
  int rounds_ = 0;          // of closer looks, begun
  bool marking_ = false, decided_ = false;
  std::int32_t trial_ = 0;  // as shown; 0: nothing has been
  bool searched_ = false;   // as shown, in that trial
  Spot here_;
  Doing doing_ = Doing::coming;
  double shown_ = -1.0, apart_ = 0.0;          // s, the newest picture, and how long after the one before
  double searching_since_ = 1e9;               // s, as shown; the search has not begun
  double deeper_ = 0.0;                        // m: so much it asks for beyond the depth it wants, as learnt
  std::int32_t marks_ = 0, marks_before_ = 0;  // as shown
  scene::Quintic path_;
  double begin_ = 0.0, last_ = -1.0;
  scene::HandTrajectory hand_;
};

}  // namespace palpate::applications::palpation
