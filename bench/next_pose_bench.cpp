// Time to choose 30 poses of 1500 candidates, one after another, with updates of the covariance; beside it
// the plain way, an inverse for each candidate (one pose of 1500), run twice to show the noise.
#include <benchmark/benchmark.h>

#include "palpate/calibration/next_pose.h"
#include "palpate/calibration/pose_candidates.h"

namespace palpate {
namespace {

calibration::PoseDesign design() {
  calibration::ArmSolution arm;
  arm.gain = Vector3::Ones();
  arm.offset = Vector3::Zero();
  arm.X_world_base = {Quaternion::Identity(), Vector3(0.1, -1.4, 1.75)};
  arm.tip_in_marker = Vector3(0.004, -0.018, -0.118);
  arm.tip_known = true;
  const calibration::ReachablePoses reach;
  Random random(1, "next pose bench");
  calibration::PoseDesign result(
      arm, calibration::joint_grid({reach.joint_range.begin(), reach.joint_range.end()}, 5),
      calibration::candidate_poses(arm, reach, 1500, random));
  for (const auto& pose : calibration::candidate_poses(arm, reach, 8, random)) result.take(pose);
  return result;
}

void thirty_poses(benchmark::State& state) {
  const calibration::PoseDesign at = design();
  for (auto _ : state) benchmark::DoNotOptimize(at.plan(30, 0));
}

void thirty_poses_exchanged(benchmark::State& state) {
  const calibration::PoseDesign at = design();
  for (auto _ : state) benchmark::DoNotOptimize(at.plan(30, 4));
}

void one_pose(benchmark::State& state) {
  const calibration::PoseDesign at = design();
  for (auto _ : state) benchmark::DoNotOptimize(at.best());
}

void one_pose_by_inverses(benchmark::State& state) {
  const calibration::PoseDesign at = design();
  for (auto _ : state) {
    std::size_t best = 0;
    double least = 1e9;
    for (std::size_t i = 0; i < 1500; ++i) {
      const double error = at.predicted_error({i});
      if (error < least) {
        least = error;
        best = i;
      }
    }
    benchmark::DoNotOptimize(best);
  }
}

void rounds(benchmark::internal::Benchmark* b) {
  b->Repetitions(5)->ReportAggregatesOnly(true)->Unit(benchmark::kMillisecond);
}

BENCHMARK(thirty_poses)->Apply(rounds);
BENCHMARK(thirty_poses_exchanged)->Apply(rounds);
BENCHMARK(one_pose)->Apply(rounds);
BENCHMARK(one_pose_by_inverses)->Apply(rounds);
BENCHMARK(one_pose_by_inverses)->Name("one_pose_by_inverses_again")->Apply(rounds);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
