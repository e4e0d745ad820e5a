#include "palpate/vision/overlay_estimate.h"

#include <gtest/gtest.h>

#include <array>

#include "palpate/vision/landmark_refinement.h"
#include "palpate/vision/synthetic_room.h"
#include "tests/chi_square.h"

namespace palpate::vision {
namespace {

using namespace synthetic;

constexpr Eigen::Index kLensSize = device::kLensParameters, kPlaces = kLensSize + 6;

// How well a kind of laboratory is calibrated, and how good its devices are. Standard deviations per axis.
struct LaboratoryKind {
  const char* name;
  double touch_mm, detection_px, tracker_turn_mrad, tracker_shift_mm;
  double lens;  // of board_lens_covariance's deviations
  device::LensParameters other_lens = device::LensParameters::Zero();
};

std::vector<LaboratoryKind> laboratory_kinds() {
  device::LensParameters wide = device::LensParameters::Zero();
  wide.head<9>() << -120, -118, 6, -9, -0.08, 0.03, -4e-4, 9e-4, -0.01;
  return {{"as the reference", 0.3, 0.04, 0.8, 0.1, 1.0},
          {"tracker and hand noisier", 0.6, 0.04, 3.0, 0.4, 1.0},
          {"a wide lens, badly calibrated, and a noisy camera", 0.3, 0.12, 0.8, 0.1, 3.0, wide}};
}

std::vector<rig::SurfaceCalibration> two_surfaces() {
  rig::SurfaceCalibration table, wall;
  Matrix3 flat;
  flat.col(0) = Vector3::UnitX(), flat.col(1) = -Vector3::UnitZ(), flat.col(2) = Vector3::UnitY();
  table.name = "table";
  table.X_world_rectangle = {Quaternion(flat), Vector3(-0.375, -1.52, 1.8)};
  table.width = 0.75, table.height = 1.0;
  wall.name = "wall";
  wall.X_world_rectangle = {Quaternion::Identity(), Vector3(-0.375, -1.52, 0.8)};
  wall.width = 0.75, wall.height = 0.6;
  Eigen::VectorXd sd(8);
  sd << 3e-4, 3e-4, 3e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4;
  table.covariance = wall.covariance = sd.cwiseAbs2().asDiagonal();
  return {table, wall};
}

// A laboratory and its calibration, by the procedures that make rigs: dots touched, then seen while the head
// turns. What is true stands beside the rig.
struct Laboratory {
  device::CameraModel lens;
  std::vector<rig::Landmark> dots;
  rig::HandEyeCalibration hand_eye;
  std::vector<rig::SurfaceCalibration> surfaces;
  Matrix6 tracker;  // covariance
  Vector6 bias;     // of the tracker, the same in all poses of a head that moves little
  double detection_px = 0.0;
  rig::Rig rig;

  Pose<World, CameraMarker> tracked(const Pose<World, CameraOptical>& camera, Random& random) const {
    return disturbed(camera * hand_eye.X_marker_camera.inverse(), Vector6(draw(tracker, random) + bias));
  }
};

Laboratory calibrated(const LaboratoryKind& kind, Random& random) {
  Laboratory lab;
  lab.lens = device::changed_lens(lens(), kind.other_lens);
  lab.dots = dots();
  lab.hand_eye = hand_eye();
  lab.tracker = diagonal(1e-3 * kind.tracker_turn_mrad, 1e-3 * kind.tracker_shift_mm);
  lab.bias = draw(diagonal(1e-3, 1e-4), random);
  lab.detection_px = kind.detection_px;
  lab.surfaces = lab.rig.surfaces = two_surfaces();
  for (auto& surface : lab.surfaces) {  // the rig's are where it believes them to be, these where they are
    const Eigen::VectorXd off = draw(surface.covariance, random);
    surface.X_world_rectangle = disturbed(surface.X_world_rectangle, Vector6(off.head<6>()));
    surface.width += off[6], surface.height += off[7];
  }
  const Eigen::MatrixXd C_lens = kind.lens * kind.lens * board_lens_covariance();
  const rig::CameraCalibration board{device::changed_lens(lab.lens, draw(C_lens, random)), C_lens};
  rig::HandEyeCalibration around_board = lab.hand_eye;
  around_board.covariance = diagonal(0.0005, 0.0003);
  around_board.X_marker_camera =
      disturbed(around_board.X_marker_camera, draw(around_board.covariance, random));
  auto touched = lab.dots;
  for (auto& dot : touched) {
    dot.place.m += normal3(random, 1e-3 * kind.touch_mm);
    dot.covariance = 1e-6 * kind.touch_mm * kind.touch_mm * Matrix3::Identity();
  }
  std::vector<LandmarkFrame> frames;
  for (int f = 0; f < 40; ++f) {
    const auto camera = camera_pose(0.2 * f);
    frames.push_back({lab.tracked(camera, random), lab.tracker,
                      sightings(lab.lens, camera, lab.dots, lab.detection_px, random)});
  }
  const auto fit = refine_landmarks(board, around_board, touched, frames, {.pixel_sd = lab.detection_px});
  EXPECT_TRUE(fit) << fit.error().message;
  lab.rig.camera = fit->value.camera;
  lab.rig.hand_eye = fit->value.hand_eye;
  lab.rig.landmarks = fit->value.landmarks;
  lab.rig.registration_covariance = fit->covariance;
  return lab;
}

enum class Seen { all, half, none };

// One picture, its pose found as the graphics server finds it, and its true overlay error: drawn with what
// the rig knows, looked at with what is true. Nothing of the estimate's derivatives is used.
struct Picture {
  OverlayPicture known;
  double squares = 0.0;  // px^2, summed over the spots seen
  int spots = 0;
};

Picture picture_of(const Laboratory& lab, const OverlayKnowledge& known, double time, Seen landmarks,
                   Random& random) {
  const auto truth = camera_pose(time);
  Picture picture;
  const auto marker = lab.tracked(truth, random);
  OverlayPicture& p = picture.known;
  p.prior = camera_from_marker(marker, lab.tracker, *lab.rig.hand_eye);
  rig::HandEyeCalibration exact = *lab.rig.hand_eye;
  exact.covariance.setZero();
  p.tracker = camera_from_marker(marker, lab.tracker, exact).covariance;
  p.pixel_sd = lab.detection_px;
  auto seen = sightings(lab.lens, truth, lab.dots, lab.detection_px, random);
  if (landmarks == Seen::half)
    std::erase_if(seen, [](const Sighting& sighting) { return sighting.landmark % 2 == 1; });
  if (landmarks == Seen::none) seen.clear();
  const device::CameraModel& drawn_lens = lab.rig.camera->model;
  p.pose = refine_camera_pose(drawn_lens, p.prior, known.landmarks, seen, {.pixel_sd = lab.detection_px});
  for (std::size_t s = 0; s < lab.surfaces.size(); ++s)
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 4; ++j) {
        const auto on = [&](const rig::SurfaceCalibration& surface) {
          return surface.X_world_rectangle *
                 Point<Rectangle>{{(i + 0.5) / 5 * surface.width, (j + 0.5) / 4 * surface.height, 0.0}};
        };
        const device::Pixel pixel = lab.lens.project((truth.inverse() * on(lab.surfaces[s])).m);
        if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 639 || pixel.y() > 479) continue;
        const auto real = drawn_lens.undistort_pixel(pixel);
        if (!real) continue;
        const device::Pixel drawn =
            drawn_lens.project_undistorted((p.pose.X_world_camera.inverse() * on(lab.rig.surfaces[s])).m);
        picture.squares += (drawn - *real).squaredNorm();
        ++picture.spots;
      }
  return picture;
}

// Three kinds of laboratories, a hundred of each; six pictures of each with all landmarks, with every second one
// and by the tracker alone.
TEST(OverlayEstimateStatistics, SaysWhatTheErrorIsOverManyCalibrations) {
  struct Sum {
    const char* seen;
    Seen landmarks;
    double squares = 0.0, expected = 0.0;
  };
  for (const auto& kind : laboratory_kinds()) {
    std::array<Sum, 3> sums{Sum{"all", Seen::all}, Sum{"half", Seen::half}, Sum{"none", Seen::none}};
    Random random(1, kind.name);
    constexpr int kLaboratories = 100;
    for (int k = 0; k < kLaboratories; ++k) {
      const Laboratory lab = calibrated(kind, random);
      const auto known = overlay_knowledge(lab.rig);
      for (auto& sum : sums)
        for (int f = 0; f < 6; ++f) {
          const Picture picture = picture_of(lab, known, 100.0 * k + 1.3 * f, sum.landmarks, random);
          ASSERT_EQ(picture.known.pose.refined, sum.landmarks != Seen::none);
          const auto parts = expected_overlay(known, picture.known);
          ASSERT_TRUE(parts);
          sum.squares += picture.squares;
          sum.expected += picture.spots * std::pow(parts->total(), 2);
        }
    }
    // Each laboratory is wrong in some five independent ways that matter.
    constexpr int kDegrees = 5 * kLaboratories;
    for (const auto& sum : sums)
      EXPECT_TRUE(tests::is_chi_square(kDegrees * sum.squares / sum.expected, kDegrees))
          << kind.name << ", seen: " << sum.seen;
  }
}

// Lens, hand-eye and landmarks come from one solve. Taken for independent, their errors would count for what
// they cancel in the picture as well: half as much again and more.
TEST(OverlayEstimateStatistics, ErrorsThatCancelAreNotCountedTwice) {
  const auto kind = laboratory_kinds().front();
  Random random(2, kind.name);
  double together = 0.0, apart = 0.0;
  for (int k = 0; k < 10; ++k) {
    const Laboratory lab = calibrated(kind, random);
    const auto known = overlay_knowledge(lab.rig);
    rig::Rig rig = lab.rig;
    rig.registration_covariance = {};
    const auto pieces = overlay_knowledge(rig);
    const Picture picture = picture_of(lab, known, 10.0 * k, Seen::all, random);
    together += std::pow(expected_overlay(known, picture.known)->total(), 2);
    apart += std::pow(expected_overlay(pieces, picture.known)->total(), 2);
  }
  EXPECT_GT(std::sqrt(apart / together), 1.4);
}

TEST(OverlayEstimate, EachUncertaintyHasItsPart) {
  Random random(3, "overlay estimate");
  Laboratory lab = calibrated(laboratory_kinds().front(), random);
  const auto known = overlay_knowledge(lab.rig);
  const Picture picture = picture_of(lab, known, 0.4, Seen::all, random);
  const auto all = expected_overlay(known, picture.known).value();
  EXPECT_GT(std::min({all.picture, all.registration, all.surfaces}), 0.005);
  EXPECT_NEAR(all.total(),
              std::sqrt(all.picture * all.picture + all.registration * all.registration +
                        all.surfaces * all.surfaces),
              1e-12);
  OverlayKnowledge lesser = known;
  for (auto& spot : lesser.spots) spot.covariance.setZero();
  EXPECT_EQ(expected_overlay(lesser, picture.known)->surfaces, 0.0);
  lesser.registration.setZero();
  EXPECT_EQ(expected_overlay(lesser, picture.known)->registration, 0.0);
  EXPECT_EQ(expected_overlay(lesser, picture.known)->picture, all.picture);
}

TEST(OverlayEstimate, SaysNothingWhereNoSpotIsInView) {
  Random random(4, "overlay estimate");
  const Laboratory lab = calibrated(laboratory_kinds().front(), random);
  OverlayPicture away;
  away.pose.X_world_camera = {Quaternion::Identity(), {0, 0, 3}};  // looks along +z, away from both
  EXPECT_FALSE(expected_overlay(overlay_knowledge(lab.rig), away));
  EXPECT_FALSE(expected_overlay(overlay_knowledge(rig::Rig{}), away));
}

// A picture cannot tell that all landmarks lie elsewhere as one body, nor that they were moved to where a
// wrong lens shows them: what is left to disagree about is the same without either.
TEST(OverlayEstimate, TheShapeOfLandmarksKnowsNothingOfWhatTheyShare) {
  const auto landmarks = dots();
  const auto n = 3 * static_cast<Eigen::Index>(landmarks.size());
  Random random(5, "overlay estimate");
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(kPlaces + n, kPlaces + n);
  Vector3 mean = Vector3::Zero();
  for (const auto& dot : landmarks) mean += dot.place.m / static_cast<double>(landmarks.size());
  Eigen::MatrixXd G(n, 6);
  for (Eigen::Index i = 0; i < n / 3; ++i) {
    const double sd = random.uniform(0.02e-3, 0.2e-3);
    own.block<3, 3>(kPlaces + 3 * i, kPlaces + 3 * i) = sd * sd * Matrix3::Identity();
    G.middleRows<3>(3 * i) << -hat(landmarks[static_cast<std::size_t>(i)].place.m - mean),
        Matrix3::Identity();
  }
  Eigen::MatrixXd shared = own;
  shared.bottomRightCorner(n, n) += G * diagonal(0.002, 0.001) * G.transpose();
  // The lens, and landmarks that follow it.
  const Eigen::MatrixXd C_lens = board_lens_covariance();
  Eigen::MatrixXd follow = Eigen::MatrixXd::Zero(n, kLensSize);
  for (Eigen::Index i = 0; i < follow.size(); ++i)
    if (C_lens(i / n, i / n) > 0.0)
      follow.data()[i] = 1e-4 * random.normal() / std::sqrt(C_lens(i / n, i / n));
  shared.topLeftCorner<kLensSize, kLensSize>() = C_lens;
  shared.block(kPlaces, 0, n, kLensSize) = follow * C_lens;
  shared.block(0, kPlaces, kLensSize, n) = C_lens * follow.transpose();
  shared.bottomRightCorner(n, n) += follow * C_lens * follow.transpose();

  const auto without = shape_covariances(landmarks, own), with = shape_covariances(landmarks, shared);
  ASSERT_EQ(with.size(), landmarks.size());
  for (std::size_t i = 0; i < with.size(); ++i) {
    const Matrix3 stated = own.block<3, 3>(kPlaces + 3 * static_cast<Eigen::Index>(i),
                                           kPlaces + 3 * static_cast<Eigen::Index>(i));
    EXPECT_LT((with[i] - without[i]).norm(), 1e-5 * stated.norm()) << i;
    EXPECT_LT(with[i].trace(), stated.trace()) << "a rigid motion takes its share";
    EXPECT_GT(with[i].trace(), 0.0);
  }
}

}  // namespace
}  // namespace palpate::vision
