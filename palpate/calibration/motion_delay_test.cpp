#include "palpate/calibration/motion_delay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>

#include "palpate/calibration/hand_eye.h"
#include "palpate/core/file.h"
#include "palpate/core/random.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

// A hand's motion that never repeats itself: twelve oscillations of no common period.
class Path {
 public:
  explicit Path(std::uint64_t seed) {
    Random random(seed, "path");
    for (auto& part : parts_) {
      part.rate = 2.0 * std::numbers::pi * random.uniform(0.1, 1.2);
      for (int c = 0; c < 6; ++c) {
        part.size[c] = random.normal(c < 3 ? 0.04 : 0.12) / (0.5 + part.rate / (2.0 * std::numbers::pi));
        part.phase[c] = random.uniform(0.0, 2.0 * std::numbers::pi);
      }
    }
  }
  Vector3 place(double t) const { return sum(t).head<3>(); }
  Quaternion turn(double t) const { return so3_exp(sum(t).tail<3>()); }

 private:
  struct Part {
    double rate = 0.0;
    Vector6 size, phase;
  };
  Vector6 sum(double t) const {
    Vector6 total = Vector6::Zero();
    for (const auto& part : parts_)
      for (int c = 0; c < 6; ++c) total[c] += part.size[c] * std::sin(part.rate * t + part.phase[c]);
    return total;
  }
  std::array<Part, 12> parts_;
};

// Noise of standard deviation 1, white or with a memory (first-order autoregression).
class Noise {
 public:
  Noise(Random& random, double memory_s) : random_(random), memory_s_(memory_s), now_(random.normal()) {}
  double after(double step_s) {
    if (memory_s_ <= 0.0) return random_.normal();
    const double kept = std::exp(-step_s / memory_s_);
    return now_ = kept * now_ + std::sqrt(1.0 - kept * kept) * random_.normal();
  }

 private:
  Random& random_;
  double memory_s_, now_;
};

struct Sampling {
  double rate_hz = 100.0, begin_s = 0.0, end_s = 30.0;
  double clock_s = 0.0;  // the stream's clock shows so much more
  double noise = 0.0, memory_s = 0.0;
  double jitter = 0.0;  // of the stamps' distances, in periods
};

std::vector<double> moments(const Sampling& s, Random& random) {
  std::vector<double> times;
  for (double i = random.uniform(); s.begin_s + i / s.rate_hz < s.end_s; ++i)
    times.push_back(s.begin_s + (i + s.jitter * random.uniform(-0.5, 0.5)) / s.rate_hz);
  return times;
}

// The path's point turned, enlarged and shifted by a frame of its own.
Motion points_of(const Path& path, const Sampling& s, Random& random) {
  const Quaternion R = so3_exp({1.0, 0.2, -0.7});
  Noise x(random, s.memory_s), y(random, s.memory_s), z(random, s.memory_s);
  std::vector<TimedPoint> points;
  for (const double t : moments(s, random)) {
    const double step = 1.0 / s.rate_hz;
    const Vector3 noise = s.noise * Vector3(x.after(step), y.after(step), z.after(step));
    points.push_back({t + s.clock_s, 1.7 * (R * (path.place(t) + noise)) + Vector3(1, 2, 3)});
  }
  return motion_of_points("points", points);
}

// Another body fixed to the path's, seen in a frame of its own.
std::vector<device::StampedPose> poses_of(const Path& path, const Sampling& s, Random& random,
                                          const Pose<World, World>& frame = {},
                                          const Pose<World, World>& mount = {}) {
  std::vector<device::StampedPose> poses;
  for (const double t : moments(s, random)) {
    const auto noise = [&]() -> Vector3 {
      return s.noise * Vector3(random.normal(), random.normal(), random.normal());
    };
    const Pose<World, World> body{so3_exp(5.0 * noise()) * path.turn(t), path.place(t) + noise()};
    const Pose<World, World> seen = frame * body * mount;
    device::StampedPose pose;
    pose.time_s = t + s.clock_s;
    pose.rotation = seen.rotation;
    pose.translation = seen.translation;
    poses.push_back(pose);
  }
  return poses;
}

// A line's position in a picture: one number that falls where the point goes on.
Motion signal_of(const Path& path, const Sampling& s, Random& random) {
  std::vector<double> time_s, values;
  Noise noise(random, s.memory_s);
  for (const double t : moments(s, random)) {
    time_s.push_back(t + s.clock_s);
    values.push_back(640.0 - 3000.0 * path.place(t).dot(Vector3(0.8, 0.0, -0.5)) +
                     3000.0 * s.noise * noise.after(1.0 / s.rate_hz));
  }
  return motion_of_signal("signal", time_s, values);
}

void expect_delay(const Motion& from, const Motion& to, double delay_s, double tolerance_s) {
  const auto found = estimate_motion_delay(from, to);
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_NEAR(found->delay_s, delay_s, tolerance_s);
  EXPECT_GT(found->correlation, 0.999);
  EXPECT_TRUE(found->warnings.empty()) << found->warnings.front();
  const auto back = estimate_motion_delay(to, from);
  ASSERT_TRUE(back.has_value()) << back.error().message;
  EXPECT_NEAR(back->delay_s, -found->delay_s, 1e-5);
}

const Pose<World, World> kFrame{so3_exp({0.3, -1.0, 0.5}), Vector3(1, 2, 3)},
    kMount{so3_exp({0.5, 0.3, -0.9}), Vector3(0.1, 0.05, -0.02)};

TEST(MotionDelay, IsFoundBetweenAllKindsOfExactRecordings) {
  const Path path(1);
  Random random(1);
  const Sampling tracker{.rate_hz = 100.0},
      camera{.rate_hz = 30.0, .begin_s = 1.0, .end_s = 32.0, .clock_s = 0.7};
  const auto poses = motion_of_poses("poses", poses_of(path, tracker, random)),
             others = motion_of_poses("others", poses_of(path, camera, random, kFrame, kMount)),
             points = points_of(path, camera, random), signal = signal_of(path, camera, random);
  const double exact = 1e-5;  // what smoothing a fast motion may cost
  expect_delay(poses, others, 0.7, exact);
  expect_delay(poses, points, 0.7, exact);
  expect_delay(poses, signal, 0.7, exact);
  expect_delay(points_of(path, tracker, random), points, 0.7, exact);
  expect_delay(points_of(path, tracker, random), signal, 0.7, exact);
  expect_delay(signal_of(path, tracker, random), signal, 0.7, exact);
}

TEST(MotionDelay, AMovedPointOfTheBodyAndAMirroredFrameDoNotMatter) {
  const Path path(2);
  Random random(2);
  const Sampling late{.rate_hz = 60.0, .clock_s = -0.25};
  std::vector<TimedPoint> points;
  for (const auto& pose : poses_of(path, late, random)) {
    const Vector3 place = pose.translation + pose.rotation * Vector3(0.0, 0.1, 0.3);
    points.push_back({pose.time_s, Vector3(-place.x(), place.y(), place.z())});
  }
  expect_delay(motion_of_poses("poses", poses_of(path, {}, random)), motion_of_points("points", points),
               -0.25, 1e-5);
}

TEST(MotionDelay, ClocksMayHaveAnyOriginAndTheStampsSpansNeedNotMeet) {
  const Path path(3);
  Random random(3);
  const auto found = estimate_motion_delay(points_of(path, {}, random),
                                           points_of(path, {.rate_hz = 30.0, .clock_s = 1.5e9}, random));
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_NEAR(found->delay_s, 1.5e9, 2e-5);
  ASSERT_EQ(found->warnings.size(), 1u);
  EXPECT_NE(found->warnings[0].find("no span in common"), std::string::npos);
}

TEST(MotionDelay, UnsortedAndRepeatedRowsChangeNothing) {
  const Path path(4);
  Random random(4);
  const auto to = points_of(path, {.rate_hz = 50.0, .clock_s = 0.1, .noise = 0.001}, random);
  std::vector<device::StampedPose> poses = poses_of(path, {.noise = 0.0002}, random);
  const auto found = estimate_motion_delay(motion_of_poses("poses", poses), to);
  for (std::size_t i = 0; i + 7 < poses.size(); i += 7) std::swap(poses[i], poses[i + 5]);
  poses.insert(poses.end(), poses.begin(), poses.begin() + 100);
  const auto again = estimate_motion_delay(motion_of_poses("poses", poses), to);
  ASSERT_TRUE(found.has_value() && again.has_value());
  EXPECT_EQ(found->delay_s, again->delay_s);
  EXPECT_EQ(found->delay_std_s, again->delay_std_s);
}

TEST(MotionDelay, GapsAndBlundersAreBorne) {
  const Path path(5);
  Random random(5);
  auto poses = poses_of(path, {.noise = 0.0003, .jitter = 0.8}, random);
  poses.erase(std::remove_if(poses.begin(), poses.end(),
                             [](const auto& p) { return std::fmod(p.time_s, 10.0) > 7.0; }),
              poses.end());
  std::vector<TimedPoint> points;
  for (const auto& p :
       poses_of(path, {.rate_hz = 30.0, .clock_s = 0.3, .noise = 0.001, .jitter = 0.5}, random))
    points.push_back(
        {p.time_s, p.translation + (random.chance(0.05) ? Vector3(0.3, -0.2, 0.1) : Vector3::Zero())});
  const auto found =
      estimate_motion_delay(motion_of_poses("poses", poses), motion_of_points("points", points));
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_NEAR(found->delay_s, 0.3, 4.0 * found->delay_std_s);
  EXPECT_LT(found->delay_std_s, 5e-4);
}

TEST(MotionDelay, EqualRatesDoNotDrawItToTheMiddleBetweenSamples) {
  // Stamps that coincide, and noise of a tenth of what the point moves between two samples: straight lines
  // between samples would answer about 0.3 ms too much.
  double sum = 0.0;
  constexpr int kRuns = 10;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Path path(run);
    Random random(run, "noise");
    std::vector<TimedPoint> from, to;
    for (int i = 0; i < 2000; ++i) {
      const double t = 0.01 * i;
      const auto noise = [&]() -> Vector3 {
        return 3e-4 * Vector3(random.normal(), random.normal(), random.normal());
      };
      from.push_back({t, path.place(t) + noise()});
      to.push_back({t, path.place(t) + noise()});
    }
    const auto found = estimate_motion_delay(motion_of_points("from", from), motion_of_points("to", to));
    ASSERT_TRUE(found.has_value()) << found.error().message;
    sum += found->delay_s / found->delay_std_s;
  }
  EXPECT_LT(std::abs(sum) / std::sqrt(kRuns), 4.0);
}

void expect_refused(const Motion& from, const Motion& to, const std::vector<std::string>& words) {
  const auto found = estimate_motion_delay(from, to);
  ASSERT_FALSE(found.has_value());
  for (const auto& word : words)
    EXPECT_NE(found.error().message.find(word), std::string::npos) << found.error().message;
}

// A pendulum, with a little of another motion.
Motion swinging(double other, double clock_s, double rate_hz, Random& random) {
  const Path path(6);
  std::vector<double> time_s, values;
  for (double t = 0.0; t < 30.0; t += 1.0 / rate_hz) {
    time_s.push_back(t + clock_s);
    values.push_back(std::sin(2.0 * std::numbers::pi * t / 1.6) + other * path.place(t).x() +
                     random.normal(0.01));
  }
  return motion_of_signal("swing", time_s, values);
}

TEST(MotionDelay, ARhythmIsRefusedWithTheDelaysThatFitAlike) {
  Random random(6);
  // Half a period off, one number falls where the other rises, which its unknown sign allows.
  const Motion late = swinging(0.0, 0.3, 40.0, random), early = swinging(0.0, 0.0, 100.0, random);
  expect_refused(early, late, {"repeats itself", "0.299", "1.09", "-0.500"});
}

TEST(MotionDelay, AMotionThatNearlyRepeatsItselfIsAnsweredWithTheRunnerUp) {
  Random random(7);
  const Motion late = swinging(1.0, 0.3, 40.0, random), early = swinging(1.0, 0.0, 100.0, random);
  const auto found = estimate_motion_delay(early, late);
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_NEAR(found->delay_s, 0.3, 1e-3);
  ASSERT_FALSE(found->warnings.empty());
  EXPECT_NE(found->warnings[0].find("nearly repeats"), std::string::npos) << found->warnings[0];
  ASSERT_FALSE(found->others.empty());
}

TEST(MotionDelay, ALimitOfTheDelayMakesARhythmUseful) {
  Random random(8);
  const auto found = estimate_motion_delay(swinging(0.0, 0.0, 100.0, random),
                                           swinging(0.0, 0.3, 40.0, random), {.longest_s = 0.4});
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_NEAR(found->delay_s, 0.3, 1e-3);
}

TEST(MotionDelay, WhatHasNoAnswerIsRefused) {
  Random random(9);
  const auto motion = points_of(Path(10), {}, random);
  expect_refused(motion, points_of(Path(11), {.clock_s = 1000.0, .noise = 0.001}, random),
                 {"no common time span", "1000."});
  std::vector<double> time_s, level;
  for (int i = 0; i < 500; ++i) time_s.push_back(0.03 * i), level.push_back(7.5);
  expect_refused(motion, motion_of_signal("level", time_s, level), {"level", "does not change"});
  for (auto& value : level) value += random.normal(0.01);
  expect_refused(motion, motion_of_signal("still", time_s, level), {"better than chance"});
  time_s.resize(8), level.resize(8);
  expect_refused(motion, motion_of_signal("few", time_s, level), {"few holds 8 samples", "at least 20"});
}

// How many of so many recordings have the truth within the stated 95 % interval.
int covered(int runs, double memory_s, bool one_number) {
  int inside = 0;
  for (int run = 0; run < runs; ++run) {
    const auto seed = static_cast<std::uint64_t>(run);
    const Path path(seed);
    Random random(seed, memory_s > 0.0 ? "correlated" : "white");
    const Sampling quick{
        .rate_hz = 60.0, .end_s = 25.0, .noise = 0.0003, .memory_s = memory_s, .jitter = 0.4},
        slow{.rate_hz = 30.0,
             .begin_s = 2.0,
             .end_s = 28.0,
             .clock_s = random.uniform(-3.0, 3.0),
             .noise = 0.002,
             .memory_s = memory_s};
    const auto from = points_of(path, quick, random);
    const auto to = one_number ? signal_of(path, slow, random) : points_of(path, slow, random);
    const auto found = estimate_motion_delay(from, to);
    EXPECT_TRUE(found.has_value());
    if (found && std::abs(found->delay_s - slow.clock_s) < 1.96 * found->delay_std_s) ++inside;
  }
  return inside;
}

TEST(MotionDelay, StatesItsErrorWithWhiteNoise) {
  EXPECT_TRUE(tests::is_binomial(covered(40, 0.0, false), 40, 0.95));
}
TEST(MotionDelay, StatesItsErrorWithCorrelatedNoise) {
  EXPECT_TRUE(tests::is_binomial(covered(40, 0.2, true), 40, 0.95));
}

// The counts are in the test's report (--gtest_output).
void expect_stated_error(double memory_s) {
  constexpr int kRuns = 300;
  for (const bool one_number : {false, true}) {
    const int inside = covered(kRuns, memory_s, one_number);
    EXPECT_TRUE(tests::is_binomial(inside, kRuns, 0.95)) << one_number;
    testing::Test::RecordProperty(one_number ? "inside_of_300_signal" : "inside_of_300_points", inside);
  }
}

TEST(MotionDelayStatistics, WhiteNoise) { expect_stated_error(0.0); }
TEST(MotionDelayStatistics, NoiseOfAShortMemory) { expect_stated_error(0.05); }
TEST(MotionDelayStatistics, NoiseOfALongMemory) { expect_stated_error(0.3); }

// A hand that moves a probe up and down: strokes of about one period, none quite like another.
Motion strokes(std::uint64_t seed, double clock_s, double rate_hz) {
  Random of_hand(seed, "strokes"), of_device(seed + 100, rate_hz > 20.0 ? "tracker" : "video");
  std::vector<double> begins{0.0}, heights;
  while (begins.back() < 18.0) {
    begins.push_back(begins.back() + of_hand.uniform(0.97, 1.03));
    heights.push_back(of_hand.uniform(0.8, 1.2));
  }
  std::vector<double> time_s, values;
  for (double t = 0.0; t < 18.0; t += 1.0 / rate_hz) {
    const auto i =
        static_cast<std::size_t>(std::upper_bound(begins.begin(), begins.end(), t) - begins.begin()) - 1;
    const double phase = (t - begins[i]) / (begins[i + 1] - begins[i]);
    time_s.push_back(t + clock_s);
    values.push_back(heights[i] * (1.0 - std::cos(2.0 * std::numbers::pi * phase)) + of_device.normal(0.05));
  }
  return motion_of_signal("strokes", time_s, values);
}

TEST(MotionDelay, StrokesOfOneHandAreInStepOnceOnly) {
  const auto found = estimate_motion_delay(strokes(1, 0.0, 11.5), strokes(1, -0.065, 38.0));
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_NEAR(found->delay_s, -0.065, 2.0 * found->delay_std_s);
  EXPECT_LT(found->delay_std_s, 0.01);
}

// How many of so many pairs of recordings, each of another hand, are taken for one motion.
int answered_strokes_of_two_hands(std::uint64_t pairs) {
  int answered = 0;
  for (std::uint64_t seed = 1; seed <= pairs; ++seed)
    answered +=
        estimate_motion_delay(strokes(seed, 0.0, 11.5), strokes(seed + 1000, -0.065, 38.0)).has_value() ? 1
                                                                                                        : 0;
  return answered;
}

TEST(MotionDelay, StrokesOfTwoHandsAreNotOneMotion) { EXPECT_EQ(answered_strokes_of_two_hands(6), 0); }
TEST(MotionDelayStatistics, StrokesOfTwoHandsAreNotOneMotion) {
  const int answered = answered_strokes_of_two_hands(50);
  testing::Test::RecordProperty("answered_of_50", answered);
  EXPECT_LE(answered, 1);
}

// The bottom of a water tank in a probe's pictures beside the tracker's poses of the probe; a peer's result is told by its makers.
TEST(MotionDelay, ALineInRecordedPicturesHasThePeersDelay) {
  constexpr double kPeers = -0.0648266;  // TemporalCalibrationResultsBaseline.xml of PlusLib
  const std::string folder = std::string(PALPATE_DATA_DIR) + "/plus_water_tank/";
  const auto probe = device::read_poses(folder + "probe.csv");
  ASSERT_TRUE(probe.has_value()) << probe.error().message;
  const auto table = read_file(folder + "line.csv");
  ASSERT_TRUE(table.has_value());
  std::vector<double> time_s, row_px;
  for (std::size_t at = table->find('\n') + 1; at < table->size(); at = table->find('\n', at) + 1) {
    char* next = nullptr;
    time_s.push_back(std::strtod(table->c_str() + at, &next));
    row_px.push_back(std::strtod(next + 1, nullptr));
  }
  ASSERT_EQ(row_px.size(), 201u);
  const Motion line = motion_of_signal("line", time_s, row_px),
               tracked = motion_of_poses("probe", probe->poses);
  for (const double longest_s : {std::numeric_limits<double>::infinity(), 0.25}) {
    const auto found = estimate_motion_delay(line, tracked, {.longest_s = longest_s});
    ASSERT_TRUE(found.has_value()) << found.error().message;
    EXPECT_NEAR(found->delay_s, kPeers, 0.005);
    EXPECT_NEAR(found->delay_s, kPeers, 1.96 * found->delay_std_s);
    EXPECT_FALSE(found->warnings.empty()) << "that it is a rhythm";
  }
}

TEST(MotionDelay, ARealRecordingHasTheDelayOfItsHandEyeCalibration) {
  const std::string name = std::string(PALPATE_DATA_DIR) + "/ethz_handeye_primesense1/2017-04-09-18-13-10_";
  const auto hand = device::read_poses(name + "vicon_prime_sense.csv"),
             eye = device::read_poses(name + "W_camera_rgb_image_raw.csv");
  ASSERT_TRUE(hand.has_value() && eye.has_value());
  const auto poses =
      estimate_motion_delay(motion_of_poses("eye", eye->poses), motion_of_poses("hand", hand->poses));
  ASSERT_TRUE(poses.has_value()) << poses.error().message;
  const auto hand_eye = calibrate_hand_eye(hand->poses, eye->poses, {.estimate_delay = true});
  ASSERT_TRUE(hand_eye.has_value());
  const auto agree = [&](const MotionDelay& found) {
    return std::abs(found.delay_s - hand_eye->value.delay_s) <
           1.96 * std::hypot(found.delay_std_s, hand_eye->value.delay_std_s);
  };
  EXPECT_TRUE(agree(*poses)) << poses->delay_s << " +- " << poses->delay_std_s;
  EXPECT_LT(poses->delay_std_s, 1e-3);
  std::vector<double> time_s, depth;
  for (const auto& pose : eye->poses) time_s.push_back(pose.time_s), depth.push_back(pose.translation.x());
  const auto number =
      estimate_motion_delay(motion_of_signal("depth", time_s, depth), motion_of_poses("hand", hand->poses));
  ASSERT_TRUE(number.has_value()) << number.error().message;
  EXPECT_TRUE(agree(*number)) << number->delay_s << " +- " << number->delay_std_s;
}

}  // namespace
}  // namespace palpate::calibration
