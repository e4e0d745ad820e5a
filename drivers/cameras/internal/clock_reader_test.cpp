// A camera's clock found by asking, beside a camera whose clock is known.
#include "drivers/cameras/internal/clock_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "palpate/core/random.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::cameras {
namespace {

std::int64_t host_now() { return MonotonicClock<GraphicsClock>::monotonic_ns(); }

// Its clock leads by an hour and gains 80 ppm; each way takes 50 us to 1 ms, but for one answer in ten.
class Camera {
 public:
  std::int64_t camera_ns(std::int64_t host_ns) const {
    const double since = static_cast<double>(host_ns - begun_);
    return host_ns + kLead_ns + static_cast<std::int64_t>(rate_ * since) + (stuck_ ? begun_ - host_ns : 0);
  }
  std::optional<ClockReading> read() {
    ++asked_;
    if (silent_ || random_.uniform(0.0, 1.0) < lost_) return std::nullopt;
    ClockReading reading;
    reading.asked_ns = host_now();
    way();
    reading.camera_ns = camera_ns(host_now());
    way();
    reading.answered_ns = host_now();
    return reading;
  }
  void set_rate(double rate) { rate_ = rate; }
  void stick() { stuck_ = true; }
  void lose(double share) { lost_ = share; }
  void fall_silent() { silent_ = true; }
  int asked() const { return asked_; }

 private:
  static constexpr std::int64_t kLead_ns = 3'600'000'000'000;
  void way() {
    const auto us = static_cast<std::int64_t>(random_.uniform(50.0, 1000.0));
    std::this_thread::sleep_for(std::chrono::microseconds(us));
  }
  std::int64_t begun_ = host_now();
  Random random_{3, "ways"};
  std::atomic<double> rate_{80e-6}, lost_{0.1};
  std::atomic<bool> stuck_{false}, silent_{false};
  std::atomic<int> asked_{0};
};

std::unique_ptr<ClockReader> reader_of(Camera& camera) {
  return ClockReader::begin([&camera] { return camera.read(); });
}

TEST(ClockReader, LeadsToTheHostsTimeWithinWhatItStates) {
  Camera camera;
  const auto reader = reader_of(camera);
  ASSERT_TRUE(reader);
  // What is stated is three standard deviations beside half a way there and back: of sixty a few may lie outside.
  int outside = 0;
  for (int i = 0; i < 60; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const std::int64_t taken = host_now(), stamp = camera.camera_ns(taken);
    // An answer may come between two questions to the reader.
    const Duration before = reader->uncertainty(stamp);
    const std::int64_t off = std::abs(reader->host_ns(stamp) - taken);
    const auto stated = static_cast<double>(std::max(before, reader->uncertainty(stamp)).count());
    ASSERT_LE(static_cast<double>(off), 1.5 * stated) << i;
    outside += static_cast<double>(off) > stated;
  }
  EXPECT_LE(outside, 6);
  EXPECT_LT(reader->uncertainty(camera.camera_ns(host_now())), std::chrono::milliseconds(10));
  EXPECT_GT(camera.asked(), 20);
}

TEST(ClockReader, GoesOnAsItWentWhereAnswersFailToCome) {
  Camera camera;
  const auto reader = reader_of(camera);
  ASSERT_TRUE(reader);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  camera.fall_silent();
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const std::int64_t taken = host_now(), stamp = camera.camera_ns(taken);
  EXPECT_LE(std::abs(reader->host_ns(stamp) - taken), reader->uncertainty(stamp).count());
}

TEST(ClockReader, IsNoneWhereNothingIsTold) {
  Camera camera;
  camera.fall_silent();
  EXPECT_FALSE(reader_of(camera));
  EXPECT_LE(camera.asked(), 5) << "it is known before the last question";
}

TEST(ClockReader, IsNoneWhereMostAnswersAreLost) {
  Camera camera;
  camera.lose(0.9);
  EXPECT_FALSE(reader_of(camera));
}

TEST(ClockReader, IsNoneWhereTheClockStandsStill) {
  Camera camera;
  camera.stick();
  EXPECT_FALSE(reader_of(camera));
}

TEST(ClockReader, IsNoneWhereTheTicksAreOfAnotherLength) {
  Camera camera;
  camera.set_rate(1.0);
  EXPECT_FALSE(reader_of(camera));
}

}  // namespace
}  // namespace palpate::drivers::cameras
