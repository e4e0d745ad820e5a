// A trial's organ, made ready for the tick: nodules drawn, the field and the law of it. The first one when the
// application begins, the next ones in a thread of their own while a trial runs, or is looked at. The same thread does what
// else follows from a search and takes its time (training.h).
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "applications/palpation/nodules.h"
#include "applications/palpation/settings.h"
#include "applications/palpation/training.h"
#include "palpate/core/broadcast_ring.h"
#include "palpate/core/expected.h"
#include "palpate/physics/organ/prepared_organ.h"
#include "palpate/physics/tissue/tissue_law.h"

namespace palpate::applications::palpation {

// $XDG_CACHE_HOME/palpate/organs, or ~/.cache/palpate/organs; empty where neither is an absolute path.
std::filesystem::path cache_folder();

// Stays where it is: the law refers to the field.
struct PreparedTrial {
  PreparedTrial(std::int32_t seed, std::vector<HiddenNodule> nodules, physics::organ::PreparedOrgan organ,
                const PalpationSettings& settings, const Pose<World, physics::tissue::Body>& rest);
  PreparedTrial(const PreparedTrial&) = delete;
  PreparedTrial& operator=(const PreparedTrial&) = delete;

  std::int32_t seed;
  std::vector<HiddenNodule> nodules;
  physics::organ::PreparedOrgan organ;
  physics::tissue::TissueLaw law;
};

// What does not change from one trial to the next.
struct TrialPlan {
  PalpationSettings settings;
  scene::TriangleMesh surface;  // pressed_mesh()
  Pose<World, physics::tissue::Body> rest;
  std::uint64_t run_seed = 1;
  std::filesystem::path cache;
};

// Of trial 1, 2, ...; takes seconds, more where the cache does not know the organ. `level`: of a staircase. Any thread, one
// call at a time.
Expected<std::unique_ptr<PreparedTrial>> prepare_trial(const TrialPlan& plan, int trial,
                                                       std::optional<int> level);

// Refused where a staircase's easiest or hardest nodules do not fit into the organ.
Expected<void> levels_fit(const TrialPlan& plan);

// The physics loop asks, a thread prepares, and the physics loop takes. tell(), want() and take() neither wait, allocate nor
// lock. What was taken before may still be in a tick's hands: it goes when the one after next is prepared.
class TrialPreparer {
 public:
  // `training` is the thread's for as long as this lives. What it has been told is heard before this goes.
  TrialPreparer(TrialPlan plan, Training& training);
  ~TrialPreparer();
  TrialPreparer(const TrialPreparer&) = delete;
  TrialPreparer& operator=(const TrialPreparer&) = delete;

  // Of a search that is over. A trial that is wanted afterwards is as hard as follows from it.
  void tell(const FinishedSearch& search) { told_.push(search); }
  void want(int trial) { wanted_.store(trial, std::memory_order_release); }
  // Exchanges `current` for the trial that was wanted, once it is ready; false, and as before, until then.
  bool take(std::unique_ptr<PreparedTrial>& current);

 private:
  void run();
  void hear();

  TrialPlan plan_;
  Training& training_;
  std::unique_ptr<PreparedTrial> slot_;       // the thread's until it is ready, then the physics loop's
  std::atomic<int> wanted_{0}, finished_{0};  // trials
  int taken_ = 0;                             // the physics loop's
  // A search takes seconds: so many wait only where the disk does not answer.
  BroadcastRing<FinishedSearch, 8> told_;
  std::uint64_t heard_ = 0;  // the thread's
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace palpate::applications::palpation
