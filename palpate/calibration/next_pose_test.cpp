#include "palpate/calibration/next_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/calibration/pose_candidates.h"
#include "palpate/core/statistics.h"
#include "palpate/math/linear_algebra.h"
#include "palpate/math/random_vector.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

// An arm with its faults, a stylus with a marker that a tracker sees, and somebody who puts it anywhere.
struct PoseLab {
  explicit PoseLab(std::uint64_t seed) : random(seed, "next pose test") {
    truth.gain = Vector3::Ones() + normal3(random, 0.012);
    truth.offset = normal3(random, 0.02);
    truth.offset[0] = 0.0;
    truth.X_world_base = {rotation_from_xyz(Vector3(0.03, -0.07, 0.01)), Vector3(0.1, -1.4, 1.75)};
    truth.tip_in_marker = Vector3(0.004, -0.018, -0.118) + normal3(random, 0.002);
    truth.tip_known = true;
    pose_covariance.setZero();
    pose_covariance.diagonal() << Vector3(9e-7, 9e-7, 9e-7), Vector3(4e-9, 4e-9, 3e-8);
  }

  // Evenly over joints, tilts and rolls, as a person spreads them.
  device::ArmObservation anywhere() {
    const Vector3 psi(random.uniform(-0.78, 0.78), random.uniform(-0.17, 1.0), random.uniform(-0.4, 1.13));
    const Vector3 towards = -predict_tip(truth, psi).m.normalized();
    const Quaternion tilt = so3_exp(0.35 * normal3(random)),
                     roll(Eigen::AngleAxisd(random.uniform(-3.1, 3.1), towards));
    return place(psi, (tilt * roll * rotation_between(Vector3::UnitZ(), towards)).normalized());
  }
  device::ArmObservation place(const Vector3& psi, const Quaternion& R) const {
    device::ArmObservation pose;
    pose.joints = psi;
    pose.marker = Pose<World, TipMarker>{R, predict_tip(truth, psi).m - R * truth.tip_in_marker};
    Eigen::Matrix<double, 3, 6> J;
    J << -hat(R * truth.tip_in_marker), Matrix3::Identity();
    pose.covariance = J * pose_covariance * J.transpose();
    return pose;
  }
  // The same as the tracker gives it.
  device::ArmObservation measured(device::ArmObservation pose) {
    const Vector3 turn = normal3(random).cwiseProduct(pose_covariance.diagonal().head<3>().cwiseSqrt()),
                  shift = normal3(random).cwiseProduct(pose_covariance.diagonal().tail<3>().cwiseSqrt());
    pose.marker->rotation = (so3_exp(turn) * pose.marker->rotation).normalized();
    pose.marker->translation += shift;
    return pose;
  }
  // What the person does who is asked for a pose: about that, 10 mm and 5 degrees off.
  device::ArmObservation about(const device::ArmObservation& wanted) {
    Vector3 psi = Vector3(wanted.joints) + normal3(random, 0.03);
    return place(psi, (so3_exp(normal3(random, 0.05)) * wanted.marker->rotation).normalized());
  }
  std::vector<device::ArmObservation> many(int count) {
    std::vector<device::ArmObservation> poses;
    for (int i = 0; i < count; ++i) poses.push_back(anywhere());
    return poses;
  }
  double error_to_truth(const ArmSolution& arm, const std::vector<Eigen::VectorXd>& places) const {
    double sum = 0.0;
    for (const auto& psi : places) sum += (predict_tip(arm, psi).m - predict_tip(truth, psi).m).squaredNorm();
    return std::sqrt(sum / static_cast<double>(places.size()));
  }

  Random random;
  ArmSolution truth{.model = {},
                    .gain = {},
                    .offset = {},
                    .X_world_base = {},
                    .tip_in_marker = {},
                    .tip_known = true,
                    .parameters = {}};
  Matrix6 pose_covariance;
};

std::vector<Eigen::VectorXd> workspace(int per_joint = 4) {
  return joint_grid({{-0.78, 0.78}, {-0.17, 1.0}, {-0.4, 1.13}}, per_joint);
}

ArmOptions with_tip_without_lengths() {
  ArmOptions options;
  options.free.lengths = false;
  return options;
}

TEST(JointGrid, CoversTheRangesEndsIncluded) {
  const auto grid = joint_grid({{-1.0, 1.0}, {0.0, 3.0}}, 3);
  ASSERT_EQ(grid.size(), 9u);
  EXPECT_EQ(Eigen::Vector2d(grid.front()), Eigen::Vector2d(-1.0, 0.0));
  EXPECT_EQ(Eigen::Vector2d(grid[4]), Eigen::Vector2d(0.0, 1.5));
  EXPECT_EQ(Eigen::Vector2d(grid.back()), Eigen::Vector2d(1.0, 3.0));
}

TEST(PoseCandidates, AreWhereArmGimbalAndTrackerAllowThem) {
  PoseLab lab(1);
  ReachablePoses reach;
  const Quaternion mount = so3_exp(Vector3(-2.4, 0.1, 0.0));
  Random random(1, "candidates");
  const auto poses = candidate_poses(lab.truth, reach, 300, random, mount, PoseNoise{lab.pose_covariance});
  ASSERT_EQ(poses.size(), 300u);
  int at_an_end = 0;
  for (const auto& pose : poses) {
    const Vector3 theta = lab.truth.gain.cwiseProduct(pose.joints) + lab.truth.offset;
    for (Eigen::Index j = 0; j < 3; ++j) {
      const auto& [low, high] = reach.joint_range[static_cast<std::size_t>(j)];
      EXPECT_GE(pose.joints[j], low);
      EXPECT_LE(pose.joints[j], high);
      at_an_end += pose.joints[j] == low || pose.joints[j] == high;
    }
    EXPECT_LE(theta[1] - theta[2], reach.largest_fold);
    const Point<World> tip = *pose.marker * Point<TipMarker>{lab.truth.tip_in_marker};
    EXPECT_LT((tip.m - predict_tip(lab.truth, pose.joints).m).norm(), 1e-12);
    const double tilt = std::acos((pose.marker->rotation * reach.marker_normal).dot(-tip.m.normalized()));
    EXPECT_LE(tilt, reach.largest_tilt + 1e-9);
    const Quaternion stylus =
        lab.truth.X_world_base.rotation.conjugate() * pose.marker->rotation * mount.conjugate();
    EXPECT_LE(std::abs(device::phantom_gimbal(theta, stylus)[1]), reach.largest_gimbal + 1e-9);
  }
  EXPECT_NEAR(at_an_end, 450, 90);  // half of all joint values; folded poses are left out unevenly
}

TEST(PoseCandidates, AnUnreachableRangeGivesNone) {
  PoseLab lab(1);
  ReachablePoses reach;
  reach.largest_fold = -10.0;
  Random random(1, "candidates");
  EXPECT_TRUE(candidate_poses(lab.truth, reach, 20, random).empty());
}

// The candidate chosen by updates is the one whose full prediction (a new inverse each) is least.
TEST(PoseDesign, TheBestCandidateIsTheBestOfAllTriedOneByOne) {
  for (double shared : {0.0, 0.0001, -1.0}) {  // the last: stated by the poses
    PoseLab lab(2);
    DesignOptions options;
    options.shared_sd = std::max(0.0, shared);
    const auto stating = [&](device::ArmObservation pose) {
      if (shared < 0.0) pose.systematic = 0.0001;
      return pose;
    };
    std::vector<device::ArmObservation> candidates;
    for (int i = 0; i < 60; ++i) candidates.push_back(stating(lab.anywhere()));
    PoseDesign design(lab.truth, workspace(), candidates, options);
    for (int taken = 0; taken < 8; ++taken) {
      const std::size_t best = design.best();
      std::size_t least = 0;
      for (std::size_t i = 1; i < 60; ++i)
        if (design.predicted_error({i}) < design.predicted_error({least})) least = i;
      EXPECT_NEAR(design.predicted_error({best}), design.predicted_error({least}),
                  1e-9 * design.predicted_error({least}))
          << taken << " poses, shared " << shared;
      design.take(stating(lab.anywhere()));
    }
  }
}

// log det C by D-optimality and by the numbers: the choice with the largest determinant of the Fisher
// information, formed here from finite differences of where arm and marker say that the tip is.
TEST(PoseDesign, DOptimalMaximisesTheDeterminantOfTheInformation) {
  PoseLab lab(3);
  const auto taken = lab.many(6), candidates = lab.many(40);
  const auto jacobian = [&lab](const device::ArmObservation& pose) {
    Eigen::MatrixXd J(3, 14);
    const auto discrepancy = [&](Eigen::Index k, double h) -> Vector3 {
      ArmSolution arm = lab.truth;
      if (k < 3)
        arm.X_world_base.rotation = so3_exp(Vector3(h * Vector3::Unit(k))) * arm.X_world_base.rotation;
      if (k >= 3 && k < 6) arm.X_world_base.translation[k - 3] += h;
      if (k >= 6 && k < 9) arm.gain[k - 6] += h;
      if (k >= 9 && k < 11) arm.offset[k - 8] += h;
      if (k >= 11) arm.tip_in_marker[k - 11] += h;
      return predict_tip(arm, pose.joints).m - (*pose.marker * Point<TipMarker>{arm.tip_in_marker}).m;
    };
    for (Eigen::Index k = 0; k < 14; ++k) J.col(k) = (discrepancy(k, 1e-6) - discrepancy(k, -1e-6)) / 2e-6;
    return J;
  };
  const auto information = [&](const device::ArmObservation& pose) -> Eigen::MatrixXd {
    const auto J = jacobian(pose);
    return J.transpose() * pose.covariance->inverse() * J;
  };
  Eigen::VectorXd size(14);  // the stated prior widths: base 1, gains 0.1, offsets 1, tip 0.1
  size << Eigen::VectorXd::Ones(6), Eigen::VectorXd::Constant(3, 0.1), Eigen::VectorXd::Ones(2),
      Eigen::VectorXd::Constant(3, 0.1);
  Eigen::MatrixXd known = size.cwiseAbs2().cwiseInverse().asDiagonal();
  for (const auto& pose : taken) known += information(pose);
  std::size_t best = 0;
  double largest = 0.0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double d = (known + information(candidates[i])).determinant();
    if (d > largest) {
      largest = d;
      best = i;
    }
  }
  DesignOptions options;
  options.criterion = DesignCriterion::d_optimal;
  PoseDesign design(lab.truth, workspace(), candidates, options);
  for (const auto& pose : taken) design.take(pose);
  EXPECT_EQ(design.best(), best);
}

// With nothing but white noise the prediction is that of the estimator: 150 calibrations of 30 poses. Of the unknowns,
// which share the error unequally, some eight count.
TEST(PoseDesign, PredictsTheErrorThatCalibrationsHave) {
  PoseLab lab(4);
  const auto poses = lab.many(30);
  DesignOptions options;
  options.shared_sd = 0.0;
  PoseDesign design(lab.truth, workspace(), {}, options);
  for (const auto& pose : poses) design.take(pose);
  double square = 0.0;
  constexpr int kRuns = 150;
  ArmOptions plain = with_tip_without_lengths();
  plain.robust = plain.allow_field = false;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<device::ArmObservation> seen;
    for (const auto& pose : poses) seen.push_back(lab.measured(pose));
    const auto estimate = calibrate_arm(seen, lab.truth.model, plain);
    ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
    square += std::pow(lab.error_to_truth(estimate->value, workspace()) / design.predicted_error(), 2);
  }
  EXPECT_TRUE(tests::is_chi_square(8 * square, 8 * kRuns));
}

// The same where near poses are shifted and turned alike: fields drawn with the stated correlation.
TEST(PoseDesign, PredictsTheErrorThatASystematicErrorBrings) {
  constexpr double kSd = 0.0003;
  DesignOptions options;
  options.shared_sd = 0.0;
  for (const bool stated : {true, false}) {
    PoseLab lab(5);
    auto poses = lab.many(30);
    if (!stated) options.shared_sd = kSd;
    for (auto& pose : poses) {
      if (!stated) continue;
      pose.systematic = kSd * std::sqrt(3.0);
      *pose.covariance += kSd * kSd * Matrix3::Identity();
    }
    PoseDesign design(lab.truth, workspace(), {}, options);
    for (const auto& pose : poses) design.take(pose);
    Eigen::MatrixXd alike(30, 30), L;
    for (Eigen::Index i = 0; i < 30; ++i)
      for (Eigen::Index j = 0; j < 30; ++j) {
        const auto place = [&](Eigen::Index k) {
          return poses[static_cast<std::size_t>(k)].marker->translation;
        };
        alike(i, j) =
            std::exp(-0.5 * (place(i) - place(j)).squaredNorm() / std::pow(options.shared_length, 2)) +
            (i == j ? 1e-9 : 0.0);
      }
    ASSERT_TRUE(lower_cholesky(alike, L));
    ArmOptions plain = with_tip_without_lengths();
    plain.robust = plain.allow_field = false;
    double square = 0.0;
    constexpr int kRuns = 150;
    for (int run = 0; run < kRuns; ++run) {
      Eigen::MatrixXd drawn(30, 6);
      for (double& x : drawn.reshaped()) x = lab.random.normal();
      drawn = (L * drawn).eval();
      std::vector<device::ArmObservation> seen;
      for (std::size_t i = 0; i < 30; ++i) {
        seen.push_back(lab.measured(poses[i]));
        const auto field = drawn.row(static_cast<Eigen::Index>(i));
        auto& marker = *seen.back().marker;
        marker.rotation =
            (so3_exp(kSd / options.shared_length * Vector3(field.tail<3>())) * marker.rotation).normalized();
        marker.translation += kSd * Vector3(field.head<3>());
      }
      const auto estimate = calibrate_arm(seen, lab.truth.model, plain);
      ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
      square += std::pow(lab.error_to_truth(estimate->value, workspace()) / design.predicted_error(), 2);
    }
    // A few smooth modes make most of it, some four.
    EXPECT_TRUE(tests::is_chi_square(4 * square, 4 * kRuns)) << stated;
  }
}

TEST(PoseDesign, TheMeanOverPlacesIsThatOfThePlaces) {
  PoseLab lab(5);
  PoseDesign design(lab.truth, workspace(3), {}, {});
  for (const auto& pose : lab.many(20)) design.take(pose);
  double square = 0.0;
  for (const auto& psi : workspace(3)) square += std::pow(design.predicted_error_at(psi), 2) / 27.0;
  EXPECT_NEAR(std::sqrt(square), design.predicted_error(), 1e-12);
}

// Exhaustive: all 364 ways to choose 3 of 12 candidates, the same one again allowed.
TEST(PoseDesign, AnExchangedPlanIsNearTheBestOfAllPlans) {
  double worst_greedy = 1.0, worst_exchanged = 1.0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    PoseLab lab(seed);
    PoseDesign design(lab.truth, workspace(3), lab.many(12), {});
    for (const auto& pose : lab.many(5)) design.take(pose);
    double least = 1e9;
    for (std::size_t a = 0; a < 12; ++a)
      for (std::size_t b = a; b < 12; ++b)
        for (std::size_t c = b; c < 12; ++c) least = std::min(least, design.predicted_error({a, b, c}));
    worst_greedy = std::max(worst_greedy, design.predicted_error(design.plan(3, 0)) / least);
    worst_exchanged = std::max(worst_exchanged, design.predicted_error(design.plan(3)) / least);
  }
  EXPECT_LE(worst_exchanged, worst_greedy);
  EXPECT_LT(worst_exchanged, 1.02);  // an exchange ends where no single one helps: near, not always at it
  EXPECT_GT(worst_greedy, 1.0);      // else the exchange has not been tried
}

TEST(PoseDesign, APlanComesInTheOrderInWhichItHelps) {
  PoseLab lab(6);
  PoseDesign design(lab.truth, workspace(), lab.many(100), {});
  for (const auto& pose : lab.many(7)) design.take(pose);
  const auto plan = design.plan(6);
  ASSERT_EQ(plan.size(), 6u);
  for (std::size_t other : plan)
    EXPECT_LE(design.predicted_error({plan[0]}), design.predicted_error({other}) + 1e-15);
}

// A tip that has been seen from one side only is looked at from another.
TEST(PoseDesign, AsksForMarkersTurnedOtherwise) {
  PoseLab lab(7);
  const Quaternion same = rotation_between(Vector3::UnitZ(), Vector3(0.0, 0.6, -0.8));
  DesignOptions options;
  options.criterion = DesignCriterion::d_optimal;
  std::vector<device::ArmObservation> taken, candidates;
  for (int i = 0; i < 15; ++i) taken.push_back(lab.place(lab.anywhere().joints, same));
  for (int i = 0; i < 30; ++i) candidates.push_back(lab.place(lab.anywhere().joints, same));
  candidates.push_back(lab.place(lab.anywhere().joints, so3_exp(Vector3(0.0, 0.0, 1.2)) * same));
  PoseDesign design(lab.truth, workspace(), candidates, options);
  for (const auto& pose : taken) design.take(pose);
  EXPECT_EQ(design.best(), 30u);
}

// An error that neighbours share is not averaged away by measuring one place again and again.
TEST(PoseDesign, SpreadsPosesWhereNeighboursErrTogether) {
  const auto spread = [](double shared) {
    PoseLab lab(8);
    DesignOptions options;
    options.shared_sd = shared;
    const auto candidates = lab.many(200);
    PoseDesign design(lab.truth, workspace(), candidates, options);
    for (const auto& pose : lab.many(8)) design.take(pose);
    double nearest = 0.0;
    const auto plan = design.plan(20, 1);
    for (std::size_t a = 0; a < plan.size(); ++a) {
      double least = 1e9;
      for (std::size_t b = 0; b < plan.size(); ++b)
        if (a != b)
          least = std::min(
              least,
              (candidates[plan[a]].marker->translation - candidates[plan[b]].marker->translation).norm());
      nearest += least / static_cast<double>(plan.size());
    }
    return nearest;
  };
  EXPECT_GT(spread(0.0003), 1.3 * spread(0.0));
}

// The system bar: 30 guided poses at least 20 % better than the median of 30 random ones, as predicted and in
// truth, with a person who puts the stylus only about where it was asked for.
TEST(PoseDesign, ThirtyGuidedPosesBeatThirtyRandomOnesByAFifth) {
  std::vector<double> random_error, guided_error, random_predicted, guided_predicted;
  const auto places = workspace();
  const auto options = with_tip_without_lengths();
  const auto judge = [&](const PoseLab& lab, const std::vector<device::ArmObservation>& poses,
                         std::vector<double>& errors, std::vector<double>& predicted) {
    const auto estimate = calibrate_arm(poses, lab.truth.model, options);
    ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
    errors.push_back(lab.error_to_truth(estimate->value, places));
    PoseDesign design(estimate->value, places, {}, {});
    for (const auto& pose : poses) design.take(pose);
    predicted.push_back(design.predicted_error());
  };
  ReachablePoses reach;
  reach.joint_range = {{{-0.78, 0.78}, {-0.17, 1.0}, {-0.4, 1.13}}};
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    PoseLab lab(seed);
    std::vector<device::ArmObservation> poses;
    for (int i = 0; i < 30; ++i) poses.push_back(lab.measured(lab.anywhere()));
    judge(lab, poses, random_error, random_predicted);
    poses.resize(8);
    ArmOptions early = options;
    early.robust = early.allow_field = false;  // few samples cannot tell outliers
    Random random(seed, "candidates");
    while (poses.size() < 30) {
      const auto estimate = calibrate_arm(poses, lab.truth.model, early);
      ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
      const auto candidates =
          candidate_poses(estimate->value, reach, 300, random, std::nullopt, PoseNoise{lab.pose_covariance});
      PoseDesign design(estimate->value, places, candidates, {});
      for (const auto& pose : poses) design.take(pose);
      for (std::size_t index : design.plan(std::min<int>(6, 30 - static_cast<int>(poses.size())), 0))
        poses.push_back(lab.measured(lab.about(candidates[index])));
    }
    judge(lab, poses, guided_error, guided_predicted);
  }
  EXPECT_LT(median(guided_predicted), 0.8 * median(random_predicted));
  EXPECT_LT(median(guided_error), 0.8 * median(random_error));
}

TEST(PoseDesign, AnArmOfRowsIsPlannedToo) {
  device::ArmModel model;
  model.kind = device::ArmModel::Kind::dh;
  model.name = "three rows";
  model.joints = {{0.0, 1.5707963, 0.3, 0.0}, {0.4, 0.0, 0.0, 0.0}, {0.3, 0.0, 0.0, 0.0}};
  model.tool_known = true;
  ArmSolution arm;
  arm.model = model;
  arm.gain = Vector3::Ones();
  arm.offset = Vector3::Zero();
  DesignOptions options;
  options.free.dh = true;
  options.free.tip = false;
  Random random(1, "rows");
  const auto somewhere = [&random] {
    device::ArmObservation pose;
    pose.joints = uniform3(random, 1.0);
    return pose;
  };
  std::vector<device::ArmObservation> candidates;
  for (int i = 0; i < 50; ++i) candidates.push_back(somewhere());
  PoseDesign design(arm, joint_grid({{-1, 1}, {-1, 1}, {-1, 1}}, 3), candidates, options);
  for (int i = 0; i < 8; ++i) design.take(somewhere());
  std::vector<std::size_t> first(12);
  std::iota(first.begin(), first.end(), 0u);
  EXPECT_LT(design.predicted_error(design.plan(12, 1)), design.predicted_error(first));
}

TEST(PoseDesign, WrongUseIsThrown) {
  PoseLab lab(1);
  EXPECT_THROW(PoseDesign(lab.truth, {}, {}), std::invalid_argument);
  EXPECT_THROW(PoseDesign(lab.truth, workspace(2), {}).best(), std::invalid_argument);
  auto flat = lab.anywhere();
  flat.covariance = Matrix3::Zero();
  EXPECT_THROW(PoseDesign(lab.truth, workspace(2), {flat}), std::invalid_argument);
  EXPECT_THROW(joint_grid({}, 3), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::calibration
