#include "palpate/calibration/pivot_rests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/device/pose_file.h"

namespace palpate::calibration {
namespace {

constexpr double kRate = 50.0;

// A tip that is put into hollows one after the other and swung there; between them it is carried about.
struct Simulated {
  Random random;
  Vector3 tip{0.11, 0.01, -0.02};
  std::vector<Vector3> hollows;
  std::vector<PivotPose> poses;
  std::vector<int> true_hollow;  // of each pose, -1 between them

  explicit Simulated(std::uint64_t seed, int count, double noise = 1e-4) : random(seed, "rests") {
    Vector3 from(0.0, 0.2, 0.0);
    for (int k = 0; k < count; ++k) {
      hollows.emplace_back(0.06 * k + random.uniform(-0.02, 0.02), random.uniform(-0.1, 0.1),
                           random.uniform(-0.1, 0.1));
      carry(from, hollows.back(), noise);
      rest(hollows.back(), k, random.uniform(3.0, 6.0), noise);
      from = hollows.back() + Vector3(0.0, 0.15, 0.0);
      carry(hollows.back(), from, noise);
    }
  }

  void add(const Vector3& place, int hollow, double noise) {
    const double t = static_cast<double>(poses.size()) / kRate;
    const Vector3 turn(0.4 * std::sin(1.1 * t), 0.35 * std::cos(1.7 * t), 0.3 * std::sin(0.6 * t));
    const Quaternion R = so3_exp(turn);
    const Vector3 off(random.normal(noise), random.normal(noise), random.normal(noise));
    poses.push_back({R, place - R * tip + off, 0, std::nullopt, t});
    true_hollow.push_back(hollow);
  }
  void carry(const Vector3& from, const Vector3& to, double noise) {
    const int steps = static_cast<int>(kRate * random.uniform(1.0, 2.0));
    for (int i = 0; i < steps; ++i) {
      const double s = static_cast<double>(i) / steps;
      add(from + s * (to - from) + Vector3(0.0, 0.0, 0.03 * std::sin(6.0 * s)), -1, noise);
    }
  }
  void rest(const Vector3& place, int hollow, double seconds_long, double noise) {
    for (int i = 0; i < static_cast<int>(kRate * seconds_long); ++i) add(place, hollow, noise);
  }
};

// A marker whose tilt goes round within two seconds: a piece of 20 degrees turns about one axis and tells no tip.
TEST(PivotRests, AQuickSwingIsARestAsWell) {
  Random random(9, "quick swing");
  const Vector3 tip(-0.01, -0.015, 0.16), hollow(0.1, -1.5, 1.2);
  std::vector<PivotPose> poses;
  for (int i = 0; i < 1000; ++i) {
    const double t = 0.01 * i;
    const bool rests = t > 2.0 && t < 8.0;
    const Vector3 tilt(0.6 * std::cos(4.0 * t), 0.6 * std::sin(4.0 * t), 0.0);
    const Quaternion R = so3_exp(rests ? tilt : Vector3(0.1, 0.0, 0.0));
    const Vector3 carried = rests ? Vector3(Vector3::Zero()) : Vector3(0.05 * (t - 2.0), 0.02 * t, 0.1);
    const Vector3 off(random.normal(1.5e-4), random.normal(1.5e-4), random.normal(1.5e-4));
    poses.push_back({R, hollow + carried - R * tip + off, 0, std::nullopt, t});
  }
  const auto rests = find_pivot_rests(poses);
  ASSERT_TRUE(rests) << rests.error().message;
  ASSERT_EQ(rests->size(), 1u);
  EXPECT_NEAR(*poses[rests->front().first].time_s, 2.0, 0.3);
  EXPECT_NEAR(*poses[rests->front().last].time_s, 8.0, 0.3);
}

TEST(PivotRests, EachHollowIsFoundOnceAndNothingBetweenThem) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Simulated made(seed, 1 + static_cast<int>(seed % 7));
    const auto rests = find_pivot_rests(made.poses);
    ASSERT_TRUE(rests) << rests.error().message;
    ASSERT_EQ(rests->size(), made.hollows.size()) << seed;
    put_segments(*rests, made.poses);
    int inside = 0, missed = 0, wrong = 0;
    for (std::size_t i = 0; i < made.poses.size(); ++i) {
      const int is = made.true_hollow[i], said = made.poses[i].segment;
      inside += is >= 0 ? 1 : 0;
      missed += is >= 0 && said != is ? 1 : 0;
      wrong += is < 0 && said >= 0 ? 1 : 0;
    }
    EXPECT_LT(missed, 0.2 * inside) << seed;
    EXPECT_LE(wrong, 2 * static_cast<int>(made.hollows.size()))
        << "poses of arriving and leaving, at most " << seed;
    const auto pivot = calibrate_pivot(made.poses);
    ASSERT_TRUE(pivot) << pivot.error().message;
    EXPECT_LT((pivot->value.tip - made.tip).norm(), 0.3e-3) << seed;
  }
}

TEST(PivotRests, OfARealRecordingTheyAreThoseThatWereMarkedByHand) {
  const auto file = device::read_poses(
      std::string(PALPATE_DATA_DIR) + "/plus_eight_landmark_pivots/stylus_to_reference.csv",
      {.transform = "", .segment_column = "landmark"});
  ASSERT_TRUE(file) << file.error().message;
  std::vector<PivotPose> marked, poses;
  for (const auto& pose : file->poses) {
    marked.push_back({pose.rotation, pose.translation, pose.segment, std::nullopt, pose.time_s});
    poses.push_back(marked.back());
    poses.back().segment = 0;
  }
  const auto rests = find_pivot_rests(poses);
  ASSERT_TRUE(rests) << rests.error().message;
  ASSERT_EQ(rests->size(), 8u);
  put_segments(*rests, poses);
  std::map<std::pair<int, int>, int> counts;
  for (std::size_t i = 0; i < poses.size(); ++i) ++counts[{marked[i].segment, poses[i].segment}];
  int both = 0;
  for (const auto& [segments, count] : counts) {
    if (segments.second >= 0) {
      EXPECT_EQ(segments.first, segments.second) << count;
    }
    if (segments.first >= 0 && segments.second >= 0) both += count;
  }
  EXPECT_GT(both, 0.8 * 706) << "of the poses that were marked";
  const auto by_hand = calibrate_pivot(marked), by_itself = calibrate_pivot(poses);
  ASSERT_TRUE(by_hand && by_itself);
  EXPECT_LT((by_hand->value.tip - by_itself->value.tip).norm(), 0.3e-3);
}

TEST(PivotRests, WhereNothingRestsOrNobodyKnowsWhenTheyAreRefused) {
  Simulated carried(3, 0);
  for (int k = 0; k < 6; ++k) carried.carry(Vector3(0.1 * k, 0, 0), Vector3(0.1 * k + 0.1, 0.1, 0.1), 1e-4);
  auto found = find_pivot_rests(carried.poses);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message.find("rest it in a hollow"), std::string::npos);
  EXPECT_FALSE(find_pivot_rests({}));
  Simulated made(1, 1);
  auto timeless = made.poses;
  timeless[3].time_s.reset();
  EXPECT_FALSE(find_pivot_rests(timeless));
  auto unsorted = made.poses;
  std::swap(unsorted[3], unsorted[4]);
  EXPECT_FALSE(find_pivot_rests(unsorted));
  auto broken = made.poses;
  broken[7].translation.x() = std::nan("");
  EXPECT_FALSE(find_pivot_rests(broken));
}

}  // namespace
}  // namespace palpate::calibration
