// A trial's organ, made ready for the tick: nodules drawn, the field and the law of it. The first one when the
// application begins, the next ones in a thread of their own while a trial runs.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "applications/palpation/nodules.h"
#include "applications/palpation/settings.h"
#include "palpate/core/expected.h"
#include "palpate/physics/organ/prepared_organ.h"
#include "palpate/physics/tissue/tissue_law.h"
#include "palpate/time/triple_buffer.h"

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

// Of trial 1, 2, ...; takes seconds, more where the cache does not know the organ. Any thread, one call at a time.
Expected<std::unique_ptr<PreparedTrial>> prepare_trial(const TrialPlan& plan, int trial);

// The physics loop asks, a thread prepares, and the physics loop takes. want() and take() neither wait, allocate nor
// lock. What was taken before may still be in a tick's hands: it goes when the one after next is prepared.
class TrialPreparer {
 public:
  explicit TrialPreparer(TrialPlan plan);
  ~TrialPreparer();
  TrialPreparer(const TrialPreparer&) = delete;
  TrialPreparer& operator=(const TrialPreparer&) = delete;

  void want(int trial) { wanted_.store(trial, std::memory_order_release); }
  // Exchanges `current` for the trial that was wanted, once it is ready; false, and as before, until then.
  bool take(std::unique_ptr<PreparedTrial>& current);

 private:
  void run();

  TrialPlan plan_;
  std::unique_ptr<PreparedTrial> slot_;       // the thread's until it is ready, then the physics loop's
  std::atomic<int> wanted_{0}, finished_{0};  // trials
  TripleBuffer<int> ready_;                   // the same as finished_, as a recording sees it
  int taken_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace palpate::applications::palpation
