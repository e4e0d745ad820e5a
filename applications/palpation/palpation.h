// PalpationApplication: press a soft organ with the tip of the stylus, and find what is hard inside.
//
// The force is a contact law's (physics/tissue), which the haptic tick evaluates; the physics loop follows the trial,
// dents the surface for the picture and shows what was found. Bodies: 0 the organ, 1 the stylus (its tip, displaced by
// the scene's carried_offset), 2 the tip's sphere, from 3 on the marks. Nodules are not in the state: when a search is
// over it holds the seed that they were drawn by. With a staircase what was found sets how hard the next trial is, which is
// prepared while the person looks at what the search has shown; finished searches go into a file where one is named. Both are
// the preparing thread's. World frame, SI. Physics thread; step() does not allocate, lock, throw
// or write text.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "applications/palpation/liver.h"
#include "applications/palpation/trial.h"
#include "applications/palpation/trial_preparer.h"
#include "palpate/scene/application.h"
#include "palpate/scene/application_registry.h"
#include "palpate/scene/contact_law.h"
#include "palpate/time/triple_buffer.h"

namespace palpate::applications::palpation {

inline constexpr int kOrgan = 0, kStylus = 1, kTip = 2, kFirstMark = 3;
static_assert(kFirstMark + static_cast<int>(kMostMarks) <= scene::SceneState::kBodies);

// Places in SceneState::counters.
enum Counter : std::size_t {
  kPhase,        // TrialPhase
  kTrial,        // 1, 2, ...
  kForceMn,      // now, mN
  kPeakForceMn,  // so far
  kDepthUm,      // now, of the tip below the resting surface, um
  kTouches,      // times the organ was met
  kHardPresses,  // of this trial, as all that follows
  kSearchMs,
  kPathMm,  // of the tip while searching
  kMarks,
  kDwellPermille,  // how far the next mark is
  kNoduleSeed,     // until the search is over 0, or -1 less the level that a staircase has set
  kFound,
  kFalseAlarms,
  kErrorUm,    // median distance between found nodules and their marks; -1 for none
  kCreatedNj,  // energy that contacts have given out without its having been put in, since the last reset
};

// The level that a state tells, of a search and after it; none: its nodules were drawn.
std::optional<int> level_told(const PalpationSettings& settings, const scene::SceneState& state);

// What the haptic tick evaluates: the law of the trial that runs.
class TrialLaw : public scene::ContactLaw {
 public:
  explicit TrialLaw(physics::tissue::TissueLaw& first) : now_(&first) {}

  // --- the haptic thread
  Vector3 force(const scene::TipState& tip, double dt) noexcept override {
    next_.read(now_);
    return now_->force(tip, dt);
  }
  double force_bound() const override { return physics::tissue::TissueLaw::kBound_n * (1.0 + 1e-9); }
  Duration cost_bound() const override { return std::chrono::microseconds(100); }

  // --- the physics thread
  void change_to(physics::tissue::TissueLaw& law) { next_.write(&law); }

 private:
  physics::tissue::TissueLaw* now_;
  TripleBuffer<physics::tissue::TissueLaw*> next_;
};

class PalpationApplication : public scene::Application {
 public:
  // The organ stands on the surface "table". Prepares the first trial, which may take half a minute where the cache
  // does not know the organ; an empty `cache` keeps nothing. Throws std::invalid_argument for settings that cannot be,
  // std::runtime_error for an organ that cannot be prepared, and for a file of searches that cannot be added to.
  PalpationApplication(const scene::SceneDescription& scene, const scene::RunSettings& run,
                       const std::filesystem::path& cache);

  void step(Instant<PhysicsClock> now, Duration dt, const scene::TipState& tip,
            scene::SceneState& state) override;
  const scene::ImpactEvent& impact() const override { return no_impact_; }
  TrialLaw* contact_law() override { return &law_; }
  std::span<const float> shape() const override { return shape_; }

  const Trial& trial() const { return trial_; }
  const PreparedTrial& prepared() const { return *prepared_; }
  const Pose<World, Body>& rest() const { return X_world_organ_; }

 private:
  void begin() override { trial_.ask(); }
  void reset() override;
  void follow_law(Instant<PhysicsClock> now, double dt);
  void next_trial();
  void tell_of_search();
  void dent(double dt);
  void show_marks(scene::SceneState& state);
  void show(const scene::TipState& tip, scene::SceneState& state);
  void count(scene::SceneState& state) const;

  PalpationSettings settings_;
  Vector3 carried_offset_;
  bool ahead_;  // the next trial is prepared before it is asked for: while one runs, or is looked at
  Pose<World, Body> X_world_organ_;
  scene::TriangleMesh surface_;
  Training training_;  // the preparer's
  std::unique_ptr<PreparedTrial> prepared_;
  TrialPreparer preparer_;
  TrialLaw law_;
  Trial trial_;
  int number_ = 1, told_ = 0;  // trials: the one that runs, the newest whose search is over
  physics::tissue::TissueTouch touch_;
  std::uint64_t resets_ = 0;
  double since_shape_ = 1.0;  // s
  bool dented_ = false;
  std::vector<Vector3> vertices_, normals_;  // Body
  std::vector<float> shape_;
  std::array<std::size_t, kMostMarks> mark_vertices_{};  // each mark's nearest
  std::array<Vector3, kMostMarks> marks_seen_{};
  std::uint32_t mark_jumps_ = 0;
  scene::ImpactEvent no_impact_;
};

}  // namespace palpate::applications::palpation
