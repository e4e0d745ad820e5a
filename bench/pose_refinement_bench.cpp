// Time of one pose refinement from a tracker's prior and 6, 12 and 40 landmarks, and of the sub-problem
// everybody solves instead: OpenCV's solvePnP from the same start and points, run twice in the same process
// to show the noise.
#include <benchmark/benchmark.h>

#include <opencv2/calib3d.hpp>

#include "palpate/vision/pose_refinement.h"
#include "palpate/vision/synthetic_room.h"

namespace palpate {
namespace {

struct Scene {
  device::CameraModel camera = vision::synthetic::lens();
  std::vector<rig::Landmark> landmarks;
  std::vector<vision::Sighting> sightings;
  vision::CameraPosePrior prior;

  explicit Scene(int count) {
    Random random(1, "refinement bench");
    const auto truth = vision::synthetic::camera_pose(0.0);
    while (static_cast<int>(sightings.size()) < count) {
      rig::Landmark landmark;
      landmark.place.m =
          Vector3(random.uniform(-0.35, 0.35), random.uniform(-1.52, -1.0), random.uniform(0.8, 1.5));
      landmark.covariance = 4e-8 * Matrix3::Identity();
      landmarks.push_back(landmark);
      sightings = vision::synthetic::sightings(camera, truth, landmarks, 0.1, random);
    }
    prior.covariance = vision::synthetic::diagonal(0.002, 0.0003);
    prior.X_world_camera =
        vision::synthetic::disturbed(truth, vision::synthetic::draw(prior.covariance, random));
  }
};

void refinement(benchmark::State& state) {
  const Scene scene(static_cast<int>(state.range(0)));
  for (auto _ : state)
    benchmark::DoNotOptimize(
        vision::refine_camera_pose(scene.camera, scene.prior, scene.landmarks, scene.sightings));
}

void solve_pnp(benchmark::State& state) {
  const Scene scene(static_cast<int>(state.range(0)));
  std::vector<cv::Point3d> places;
  std::vector<cv::Point2d> pixels;
  for (const auto& seen : scene.sightings) {
    const auto& m = scene.landmarks[seen.landmark].place.m;
    places.emplace_back(m.x(), m.y(), m.z());
    pixels.emplace_back(seen.centre.x(), seen.centre.y());
  }
  const auto& c = scene.camera;
  const cv::Mat K = (cv::Mat_<double>(3, 3) << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  const std::vector<double> distortion(c.coefficients().begin(), c.coefficients().end());
  const auto start = scene.prior.X_world_camera.inverse();
  const Vector3 turn = so3_log(start.rotation);
  for (auto _ : state) {
    cv::Vec3d r(turn.x(), turn.y(), turn.z()),
        t(start.translation.x(), start.translation.y(), start.translation.z());
    benchmark::DoNotOptimize(cv::solvePnP(places, pixels, K, distortion, r, t, true, cv::SOLVEPNP_ITERATIVE));
  }
}

void rounds(benchmark::internal::Benchmark* b) {
  b->Arg(6)->Arg(12)->Arg(40)->Repetitions(10)->ReportAggregatesOnly(true)->Unit(benchmark::kMicrosecond);
}

BENCHMARK(refinement)->Apply(rounds);
BENCHMARK(solve_pnp)->Apply(rounds);
BENCHMARK(solve_pnp)->Name("solve_pnp_again")->Apply(rounds);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
