#include "applications/palpation/trial_preparer.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>

#include "palpate/core/log.h"
#include "palpate/core/stop_signal.h"
#include "palpate/time/input_trace.h"

namespace palpate::applications::palpation {
namespace {

constexpr Log kPreparationLog("palpation");
constexpr double kSpacingShare = 0.7;  // of the elements: how far sites along the surface are apart

physics::tissue::TissueSettings tissue_settings(const PalpationSettings& settings) {
  physics::tissue::TissueSettings tissue;
  tissue.dissipation.friction = settings.friction;
  tissue.dissipation.poisson = settings.poisson;
  tissue.young_pa = settings.young_pa;
  return tissue;
}

physics::organ::OrganSettings organ_settings(const TrialPlan& plan,
                                             const std::vector<HiddenNodule>& nodules) {
  physics::organ::OrganSettings organ;
  organ.young_pa = plan.settings.young_pa;
  organ.poisson = plan.settings.poisson;
  organ.tip_radius = plan.settings.tip_radius;
  organ.deepest = plan.settings.deepest;
  organ.element = plan.settings.element;
  organ.site_spacing = kSpacingShare * plan.settings.element;
  for (const auto& nodule : nodules) organ.nodules.push_back(nodule.ball);
  organ.cache = plan.cache;
  return organ;
}

// A line when it begins to take long, and one every few seconds.
class SlowSteps {
 public:
  void tell(std::string_view what, double share) {
    constexpr std::chrono::seconds kPatience{3};
    const auto now = std::chrono::steady_clock::now();
    if (now - told_ < kPatience) return;
    told_ = now;
    kPreparationLog.info("preparing the organ, {:.0f} %: {}", 100.0 * std::clamp(share, 0.0, 1.0), what);
  }

 private:
  std::chrono::steady_clock::time_point told_ = std::chrono::steady_clock::now();
};

std::uint64_t seed_of_run(const TrialPlan& plan) {
  return plan.settings.nodule_seed > 0 ? plan.settings.nodule_seed : plan.run_seed;
}

}  // namespace

std::filesystem::path cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && *cache == '/') return std::filesystem::path(cache) / "palpate" / "organs";
  const char* home = std::getenv("HOME");
  if (home != nullptr && *home == '/') return std::filesystem::path(home) / ".cache" / "palpate" / "organs";
  return {};
}

PreparedTrial::PreparedTrial(std::int32_t seed_of_nodules, std::vector<HiddenNodule> hidden,
                             physics::organ::PreparedOrgan prepared, const PalpationSettings& settings,
                             const Pose<World, physics::tissue::Body>& rest)
    : seed(seed_of_nodules),
      nodules(std::move(hidden)),
      organ(std::move(prepared)),
      law(organ.field, tissue_settings(settings), rest) {}

Expected<std::unique_ptr<PreparedTrial>> prepare_trial(const TrialPlan& plan, int trial,
                                                       std::optional<int> level) {
  const std::int32_t seed = trial_seed(seed_of_run(plan), trial, level);
  auto nodules = draw_nodules(plan.surface, plan.settings, seed);
  if (!nodules) return tl::unexpected(nodules.error());
  SlowSteps steps;
  auto organ = physics::organ::prepare_organ(
      plan.surface, organ_settings(plan, *nodules), [&steps](std::string_view what, double share) {
        steps.tell(what, share);
        return !told_to_stop();  // it takes seconds, and who has pressed Ctrl-C does not wait for it
      });
  if (!organ) return tl::unexpected(organ.error());
  if (const auto good = physics::tissue::TissueLaw::renders(organ->field); !good)
    return tl::unexpected(good.error());
  return std::make_unique<PreparedTrial>(seed, std::move(*nodules), std::move(*organ), plan.settings,
                                         plan.rest);
}

Expected<void> levels_fit(const TrialPlan& plan) {
  if (plan.settings.difficulty != Difficulty::staircase) return {};
  PalpationSettings settings = plan.settings;
  settings.nodules.fewest = settings.nodules.most;
  for (const int level : {0, kHardestLevel}) {
    const auto drawn = draw_nodules(plan.surface, settings, trial_seed(seed_of_run(plan), 1, level));
    if (!drawn) return refused("{} (level {})", drawn.error().message, level);
  }
  return {};
}

TrialPreparer::TrialPreparer(TrialPlan plan, Training& training)
    : plan_(std::move(plan)), training_(training), thread_([this] { run(); }) {}

TrialPreparer::~TrialPreparer() {
  stop_ = true;
  thread_.join();
}

bool TrialPreparer::take(std::unique_ptr<PreparedTrial>& current) {
  const int newest = finished_.load(std::memory_order_acquire);
  // What this tick learns of the thread. Where a recording is executed again, the recording says so, and the trial may have
  // to be waited for; one that nobody has wanted never comes.
  const std::uint64_t learned = InputTrace::pass(newest > taken_ ? static_cast<std::uint64_t>(newest) : 0);
  if (learned <= static_cast<std::uint64_t>(taken_) ||
      learned > static_cast<std::uint64_t>(wanted_.load(std::memory_order_relaxed)))
    return false;
  const int ready = static_cast<int>(learned);
  for (int now = finished_.load(std::memory_order_acquire); now < ready;
       now = finished_.load(std::memory_order_acquire))
    finished_.wait(now, std::memory_order_acquire);
  taken_ = ready;
  if (!slot_) return false;
  std::swap(current, slot_);
  return true;
}

void TrialPreparer::run() {
  constexpr std::chrono::milliseconds kLook{50};
  int prepared = 0;
  while (!stop_) {
    std::this_thread::sleep_for(kLook);
    // First what is wanted: what was told before that is heard before it is prepared.
    const int wanted = wanted_.load(std::memory_order_acquire);
    hear();
    if (wanted <= prepared) continue;
    std::this_thread::sleep_for(kLook);  // no tick holds on to what was exchanged so long ago
    auto trial = prepare_trial(plan_, wanted, training_.level());
    if (!trial && !told_to_stop())
      kPreparationLog.warning("trial {} cannot be prepared: {}", wanted, trial.error().message);
    slot_ = trial ? std::move(*trial) : nullptr;
    prepared = wanted;
    finished_.store(wanted, std::memory_order_release);
    finished_.notify_all();
  }
  hear();
}

void TrialPreparer::hear() {
  for (const std::uint64_t told = told_.count(); heard_ < told; ++heard_) {
    FinishedSearch search;
    if (told_.read(heard_, search))
      training_.hear(search);
    else
      kPreparationLog.warning(
          "warning: a search came while those before it could not be kept; it is left out");
  }
}

}  // namespace palpate::applications::palpation
