// Time of one joint calibration of the arm (30, 70, 140 poses) and of the same least-squares problem as one
// writes it down with Ceres: a residual block per pose, automatic derivatives, a robust loss. Ours does more:
// starts, weights, outliers, covariance. The rival runs twice in the same process to show the noise.
#include <benchmark/benchmark.h>
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <array>

#include "palpate/calibration/arm.h"
#include "palpate/math/random_vector.h"

namespace palpate {
namespace {

constexpr double kNoise = 1e-4;  // m per axis

std::vector<device::ArmObservation> recording(int poses) {
  Random random(1, "arm bench");
  calibration::ArmSolution truth;
  truth.gain = Vector3::Ones() + normal3(random, 0.012);
  truth.offset = normal3(random, 0.02);
  truth.X_world_base = {rotation_from_xyz(Vector3(0.03, -0.07, 0.01)), Vector3(0.1, -1.4, 1.75)};
  std::vector<device::ArmObservation> samples;
  for (int i = 0; i < poses; ++i) {
    const Vector3 theta(random.uniform(-0.78, 0.78), random.uniform(-0.17, 1.48),
                        random.uniform(-0.43, 1.13));
    device::ArmObservation sample;
    sample.joints = (theta - truth.offset).cwiseQuotient(truth.gain);
    const Vector3 tip = calibration::predict_tip(truth, sample.joints).m;
    const Quaternion turn = truth.X_world_base.rotation * device::phantom_stylus(theta, normal3(random, 0.5));
    const Vector3 tip_in_marker(0.004, -0.018, -0.118);
    sample.marker = Pose<World, TipMarker>{turn, tip - turn * tip_in_marker + normal3(random, kNoise)};
    sample.covariance = kNoise * kNoise * Matrix3::Identity();
    sample.systematic = 0.0;
    samples.push_back(sample);
  }
  return samples;
}

const calibration::ArmOptions kOptions{
    .free = {.gains = true, .offsets = true, .lengths = false, .tip = true}};

void joint(benchmark::State& state) {
  const auto samples = recording(static_cast<int>(state.range(0)));
  for (auto _ : state)
    benchmark::DoNotOptimize(calibration::calibrate_arm(samples, device::ArmModel{}, kOptions));
}

// Ours where the covariance has to allow for a systematic error of the tracker.
void joint_with_field(benchmark::State& state) {
  auto samples = recording(static_cast<int>(state.range(0)));
  for (auto& sample : samples) sample.systematic.reset();
  for (auto _ : state)
    benchmark::DoNotOptimize(calibration::calibrate_arm(samples, device::ArmModel{}, kOptions));
}

struct PoseResidual {
  const device::ArmObservation& sample;

  template <typename T>
  bool operator()(const T* const turn, const T* const place, const T* const gain, const T* const offset,
                  const T* const tip, T* residual) const {
    const device::PhantomLengths lengths;
    const T t1 = gain[0] * sample.joints[0];
    const T t2 = gain[1] * sample.joints[1] + offset[0];
    const T t3 = gain[2] * sample.joints[2] + offset[1];
    const T reach = lengths.l1 * cos(t2) + lengths.l2 * sin(t3);
    const T in_base[3] = {sin(t1) * reach, lengths.l2 - lengths.l2 * cos(t3) + lengths.l1 * sin(t2),
                          -lengths.l1 + cos(t1) * reach};
    T predicted[3];
    ceres::AngleAxisRotatePoint(turn, in_base, predicted);
    const Matrix3 R = sample.marker->matrix();
    for (int i = 0; i < 3; ++i) {
      const T measured =
          R(i, 0) * tip[0] + R(i, 1) * tip[1] + R(i, 2) * tip[2] + sample.marker->translation[i];
      residual[i] = (predicted[i] + place[i] - measured) / kNoise;
    }
    return true;
  }
};

void ceres_automatic(benchmark::State& state) {
  const auto samples = recording(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    std::array<double, 3> turn{}, place{}, gain{1.0, 1.0, 1.0}, tip{};
    std::array<double, 2> offset{};
    ceres::Problem problem;
    for (const auto& sample : samples)
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PoseResidual, 3, 3, 3, 3, 2, 3>(new PoseResidual{sample}),
          new ceres::CauchyLoss(2.0), turn.data(), place.data(), gain.data(), offset.data(), tip.data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-12;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    benchmark::DoNotOptimize(tip);
    if (summary.termination_type != ceres::CONVERGENCE) state.SkipWithError("Ceres did not converge");
  }
}

void rounds(benchmark::internal::Benchmark* b) {
  b->Arg(30)->Arg(70)->Arg(140)->Repetitions(10)->ReportAggregatesOnly(true)->Unit(benchmark::kMicrosecond);
}

BENCHMARK(joint)->Apply(rounds);
BENCHMARK(joint_with_field)->Apply(rounds);
BENCHMARK(ceres_automatic)->Apply(rounds);
BENCHMARK(ceres_automatic)->Name("ceres_automatic_again")->Apply(rounds);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
