#include "palpate/calibration/overlay_estimate.h"

#include <gtest/gtest.h>

#include <array>

#include "palpate/calibration/landmark_refinement.h"
#include "palpate/calibration/synthetic_room.h"

namespace palpate {
namespace {

using namespace synthetic;

constexpr double kLensSd[9] = {0.6, 0.6, 0.8, 0.8, 4e-3, 8e-3, 4e-4, 4e-4, 6e-3};

// A rig that states what it was drawn with: landmarks whose shape is known to 0.05 mm and whose place as one
// body is not; two surfaces; a lens.
Rig stated_rig() {
  Rig rig;
  rig.camera.emplace();
  rig.camera->model = lens();
  rig.camera->covariance = Eigen::MatrixXd::Zero(9, 9);
  for (int i = 0; i < 9; ++i) rig.camera->covariance(i, i) = kLensSd[i] * kLensSd[i];
  rig.landmarks = dots();
  for (auto& dot : rig.landmarks) dot.covariance = 0.00005 * 0.00005 * Matrix3::Identity();
  rig.landmarks_shared = diagonal(0.0004, 0.0002);
  Eigen::VectorXd surface(8);
  surface << 3e-4, 3e-4, 3e-4, 2e-4, 2e-4, 2e-4, 2e-4, 2e-4;
  SurfaceCalibration table, wall;
  table.name = "table";
  Matrix3 flat;
  flat.col(0) = Vector3::UnitX(), flat.col(1) = -Vector3::UnitZ(), flat.col(2) = Vector3::UnitY();
  table.X_world_rectangle = {Quaternion(flat), Vector3(-0.375, -1.52, 1.8)};
  table.width = 0.75, table.height = 1.0;
  wall.name = "wall";
  wall.X_world_rectangle = {Quaternion::Identity(), Vector3(-0.375, -1.52, 0.8)};
  wall.width = 0.75, wall.height = 0.6;
  table.covariance = wall.covariance = surface.cwiseAbs2().asDiagonal();
  rig.surfaces = {table, wall};
  return rig;
}

// One laboratory in which the rig is wrong as it says it may be: the true overlay error of one frame,
// squared, summed over the spots seen, found by drawing with what is known and looking with what is true.
// Nothing of the estimate's derivatives is used.
struct Laboratory {
  double squares = 0.0;
  int spots = 0;
  RefinedPose pose;
};

Laboratory one_laboratory(const Rig& rig, Random& random, double time, bool landmarks_seen) {
  CameraModel true_lens = rig.camera->model;
  std::array<double*, 9> terms{&true_lens.fx, &true_lens.fy, &true_lens.cx, &true_lens.cy};
  for (std::size_t i = 0; i < 5; ++i) terms[4 + i] = &true_lens.distortion[i];
  for (std::size_t i = 0; i < 9; ++i) *terms[i] += kLensSd[i] * random.normal();
  // Where the landmarks truly are.
  auto real = rig.landmarks;
  Vector3 mean = Vector3::Zero();
  for (const auto& dot : real) mean += dot.place.m / static_cast<double>(real.size());
  const Vector6 motion = draw(rig.landmarks_shared, random);
  for (auto& dot : real)
    dot.place.m =
        mean + so3_exp(motion.head<3>()) * (dot.place.m - mean) + motion.tail<3>() + normal3(random, 0.00005);
  const auto truth = camera_pose(time);
  const auto P = diagonal(0.002, 0.0003);
  const CameraPosePrior prior{disturbed(truth, draw(P, random)), P};
  std::vector<Sighting> seen;
  if (landmarks_seen) seen = sightings(true_lens, truth, real, 0.1, random);
  Laboratory lab;
  lab.pose = refine_camera_pose(rig.camera->model, prior, rig.landmarks, seen);
  for (const auto& surface : rig.surfaces) {
    Eigen::VectorXd off(8);
    for (Eigen::Index i = 0; i < 8; ++i) off[i] = std::sqrt(surface.covariance(i, i)) * random.normal();
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 4; ++j) {
        const double u = (i + 0.5) / 5, v = (j + 0.5) / 4;
        const Quaternion R = surface.X_world_rectangle.rotation;
        const Vector3 known =
            surface.X_world_rectangle.translation + R * Vector3(u * surface.width, v * surface.height, 0.0);
        const Vector3 there = surface.X_world_rectangle.translation + off.segment<3>(3) +
                              so3_exp(off.head<3>()) * (R * Vector3(u * (surface.width + off[6]),
                                                                    v * (surface.height + off[7]), 0.0));
        const Vector3 p = (truth.inverse() * Point<World>{there}).m;
        const Pixel pixel = true_lens.project(p);
        if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 639 || pixel.y() > 479) continue;
        const auto real_pixel = rig.camera->model.undistort_pixel(pixel);
        if (!real_pixel) continue;
        const Pixel drawn = rig.camera->model.project_undistorted(
            (lab.pose.X_world_camera.inverse() * Point<World>{known}).m);
        lab.squares += (drawn - *real_pixel).squaredNorm();
        ++lab.spots;
      }
  }
  return lab;
}

TEST(OverlayEstimate, SaysWhatTheErrorIsOverManyLaboratories) {
  const Rig rig = stated_rig();
  const auto known = overlay_knowledge(rig);
  for (const bool landmarks_seen : {true, false}) {
    Random random(landmarks_seen ? 1 : 2, "overlay estimate");
    double squares = 0.0, expected = 0.0;
    int spots = 0;
    constexpr int kRuns = 300;
    for (int k = 0; k < kRuns; ++k) {
      const auto lab = one_laboratory(rig, random, 0.1 * k, landmarks_seen);
      ASSERT_EQ(lab.pose.refined, landmarks_seen);
      squares += lab.squares;
      spots += lab.spots;
      const auto parts = expected_overlay(known, lab.pose);
      ASSERT_TRUE(parts);
      expected += lab.spots * parts->total() * parts->total();
    }
    // 300 laboratories, each wrong in some ten independent ways: 3 %; the lens enters by first derivatives.
    EXPECT_NEAR(std::sqrt(expected / squares), 1.0, 0.10) << "landmarks seen: " << landmarks_seen;
    RecordProperty("rms_px", std::to_string(std::sqrt(squares / spots)));
  }
}

TEST(OverlayEstimate, EachUncertaintyHasItsPart) {
  const Rig rig = stated_rig();
  Random random(3, "overlay estimate");
  const auto lab = one_laboratory(rig, random, 0.4, true);
  const auto all = expected_overlay(overlay_knowledge(rig), lab.pose).value();
  EXPECT_GT(std::min({all.pose, all.landmarks, all.surfaces, all.lens}), 0.005);
  Rig lesser = rig;
  for (auto& surface : lesser.surfaces) surface.covariance = {};
  EXPECT_EQ(expected_overlay(overlay_knowledge(lesser), lab.pose)->surfaces, 0.0);
  lesser.camera->covariance = {};
  EXPECT_EQ(expected_overlay(overlay_knowledge(lesser), lab.pose)->lens, 0.0);
  EXPECT_LT(expected_overlay(overlay_knowledge(lesser), lab.pose)->total(), all.total());
}

TEST(OverlayEstimate, SaysNothingWhereNoSpotIsInView) {
  const Rig rig = stated_rig();
  RefinedPose away;
  away.X_world_camera = {Quaternion::Identity(), {0, 0, 3}};  // looks along +z, away from both
  EXPECT_FALSE(expected_overlay(overlay_knowledge(rig), away));
  EXPECT_FALSE(expected_overlay(overlay_knowledge(Rig{}), away));
}

TEST(OverlayEstimate, LandmarksOnlyTouchedMoveTogetherByTheMeanOfTheirErrors) {
  Rig rig = stated_rig();
  rig.landmarks_shared.setZero();
  for (auto& dot : rig.landmarks) dot.covariance = 0.0003 * 0.0003 * Matrix3::Identity();
  const auto known = overlay_knowledge(rig);
  for (Eigen::Index i = 3; i < 6; ++i)
    EXPECT_NEAR(std::sqrt(known.landmarks_shared(i, i)), 0.0003 / std::sqrt(12.0), 1e-9);
}

}  // namespace
}  // namespace palpate
