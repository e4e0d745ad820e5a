// What `palpate status` is told of a graphics server, beside what the server went through on a virtual clock.
#include "palpate/server/graphics/graphics_figures.h"

#include <gtest/gtest.h>

#include "palpate/server/graphics/devices_for_tests.h"
#include "palpate/transport/exchange_rig_test.h"

namespace palpate::server::graphics {
namespace {

// A physics server whose clock is 93 s ahead of ours (exchange_rig_test.h), 0.7 ms away; images at 25 Hz and
// samples at 100 Hz, where they come.
class Figures : public ::testing::Test {
 protected:
  void run(double seconds_run, bool camera_works, bool tracker_works) {
    for (int i = 0; i < static_cast<int>(1e3 * seconds_run); ++i, ++ms_) {
      exchange_.wait_a_little();
      if (camera_works && ms_ % 40 == 0)
        camera_.next = device::CameraImage{
            {std::chrono::milliseconds(ms_)}, static_cast<std::uint64_t>(ms_ / 40), 640, 480, {}};
      if (tracker_works && ms_ % 10 == 0) {
        device::TrackerSample sample;
        sample.stamp = {std::chrono::milliseconds(ms_)};
        sample.marker = device::MarkerId::camera_marker;
        sample.seen = true;
        tracker_.next.push_back(sample);
      }
      server_.service(now());
      for (const double s : server_.take_round_trips()) trips_.add(seconds(s));
    }
  }
  Instant<GraphicsClock> now() const { return {exchange_.network.now().since_epoch + seconds(7.0)}; }
  transport::ClientFigures figures() const { return figures_of(60, 4, 2, 2.5, trips_, server_, now()); }

  transport::testing::InProcessRig exchange_{
      {.delay = std::chrono::microseconds(700), .jitter = Duration(0)}};
  std::unique_ptr<transport::StateService> service_ = std::move(*exchange_.serve());
  std::unique_ptr<transport::StateLink> link_ = exchange_.connect();
  HandedCamera camera_;
  HandedTracker tracker_;
  NullFramePipeline pipeline_;
  GraphicsServer server_{calibrated_rig(), *link_, tracker_, camera_, pipeline_};
  JitterHistogram trips_;
  int ms_ = 0;
};

TEST_F(Figures, CountsRatesTripsAndClockAreThoseOfTheRun) {
  run(1.0, true, true);
  for (int i = 0; i < 98; ++i) trips_.add(seconds(300e-6));
  for (int i = 0; i < 2; ++i) trips_.add(seconds(5000e-6));
  const auto told = figures();
  EXPECT_EQ(told.frames, 60u);
  EXPECT_EQ(told.late, 4u);
  EXPECT_EQ(told.lost, 2u);
  EXPECT_DOUBLE_EQ(told.rate_hz, 24.0);
  // The histogram keeps a value to a sixteenth of itself.
  EXPECT_NEAR(told.round_trip_median_us, 300.0, 300.0 / 16.0);
  EXPECT_NEAR(told.round_trip_p99_us, 5000.0, 5000.0 / 16.0);
  // Delays alike in both directions: their share cancels, and what is stated lies below the round trip.
  EXPECT_NEAR(told.clock_offset_s, 93.0, 1e-6);
  EXPECT_GT(told.clock_uncertainty_us, 0.0);
  EXPECT_LT(told.clock_uncertainty_us, 1400.0);
  EXPECT_TRUE(told.conditions.empty()) << told.conditions.front().words;
}

TEST_F(Figures, BeforeTheFirstExchangeNothingIsSaidOfTheClock) {
  const auto told = figures();
  EXPECT_EQ(told.clock_offset_s, 0.0);
  EXPECT_EQ(told.clock_uncertainty_us, 0.0);
}

TEST_F(Figures, CameraAndTrackerThatFallSilentAreToldAsLongAsTheyAre) {
  run(1.0, true, true);
  run(1.0, false, true);
  auto told = figures().conditions;
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].words.find("camera: no image any more, one every 40 ms is expected"), 0u)
      << told[0].words;
  run(1.0, false, false);
  told = figures().conditions;
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[1].words.find("tracker: no samples"), 0u) << told[1].words;
  run(1.0, true, false);
  told = figures().conditions;
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].words.find("tracker: no samples"), 0u) << told[0].words;
  run(1.0, true, true);
  EXPECT_TRUE(figures().conditions.empty());
}

}  // namespace
}  // namespace palpate::server::graphics
