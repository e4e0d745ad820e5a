#include "palpate/sim/world_process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <thread>

#include "drivers/laboratory/channel.h"
#include "palpate/core/log.h"
#include "tests/scratch_folder.h"

namespace palpate::sim {
namespace {

TEST(WorldProcess, ServesArmTrackerHandAndPicturesAcrossTheChannel) {
  WorldProcessOptions options;
  options.name = "world-process-test";
  const ScratchFolder folder;
  options.folder = folder.path();
  options.make_renderer = [] {
    return [](const TrueView& view, std::vector<std::uint8_t>& rgb) {
      rgb.assign(static_cast<std::size_t>(view.lens.width * view.lens.height) * 3, 42);
    };
  };
  std::atomic<bool> stop{false};
  Expected<WorldProcessReport> report = refused("not run");
  std::thread process([&] { report = run_world(config::reference_world(), options, stop); });

  const MonotonicClock<PhysicsClock> clock;
  const auto patience = clock.now() + seconds(10.0);
  MonotonicClock<PhysicsClock> waiting;
  const auto wait = [&] { waiting.sleep_until(clock.now() + std::chrono::milliseconds(2)); };
  Expected<std::shared_ptr<drivers::laboratory::LabClient>> client = refused("not opened");
  while (!client && clock.now() < patience) {
    client = drivers::laboratory::LabClient::open(options.name, options.folder);
    wait();
  }
  if (client) {
    auto arm = drivers::laboratory::LabArm::open(*client);
    auto hand = drivers::laboratory::LabHand::open(*client);
    auto camera = drivers::laboratory::LabCamera::open(*client);
    drivers::laboratory::LabTracker tracker(*client);
    EXPECT_TRUE(arm && hand && camera);
    if (arm && hand && camera) {
      const auto first = (*arm)->read();
      device::HandTarget target;
      target.tip.m = Vector3(0.0, -1.30, 1.75);
      std::size_t tracked = 0;
      std::optional<device::CameraImage> image;
      Vector3 moved = Vector3::Zero();
      while (clock.now() < patience && (moved.norm() < 0.1 || tracked < 10 || !image)) {
        (*hand)->move_to(target);
        moved = (*arm)->read().joints - first.joints;
        tracked += tracker.poll().size();
        if (auto next = (*camera)->poll()) image = std::move(next);
        wait();
      }
      EXPECT_GE(moved.norm(), 0.1);  // the hand took the stylus 0.1 m away
      EXPECT_GE(tracked, 10u);
      ASSERT_TRUE(image);
      EXPECT_EQ(image->rgb.size(), 640u * 480u * 3u);
      EXPECT_EQ(image->rgb.back(), 42);
    }
  } else {
    ADD_FAILURE() << client.error().message;
  }
  stop = true;
  process.join();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_GT(report->ticks, 0u);
}

TEST(WorldProcess, TwoCamerasShowTheSameMomentEachThroughItsOwnLens) {
  WorldProcessOptions options;
  options.name = "world-process-two-eyes";
  const ScratchFolder folder;
  options.folder = folder.path();
  // A picture that says which lens it was taken through.
  options.make_renderer = [] {
    return [](const TrueView& view, std::vector<std::uint8_t>& rgb) {
      rgb.assign(static_cast<std::size_t>(view.lens.width * view.lens.height) * 3,
                 static_cast<std::uint8_t>(view.lens.fx - 500.0));
    };
  };
  auto file = config::reference_world();
  file.camera.count = 2;
  file.camera.drop = 0.0;
  std::atomic<bool> stop{false};
  Expected<WorldProcessReport> report = refused("not run");
  std::thread process([&] { report = run_world(file, options, stop); });
  const MonotonicClock<PhysicsClock> clock;
  const auto patience = clock.now() + seconds(10.0);
  MonotonicClock<PhysicsClock> waiting;
  std::optional<device::CameraImage> left, right;
  std::shared_ptr<drivers::laboratory::LabClient> client;
  std::array<std::unique_ptr<drivers::laboratory::LabCamera>, 2> cameras;
  while (clock.now() < patience && !(left && right && left->frame == right->frame)) {
    waiting.sleep_until(clock.now() + std::chrono::milliseconds(2));
    if (!client) {
      auto opened = drivers::laboratory::LabClient::open(options.name, options.folder);
      if (!opened) continue;
      client = *opened;
      for (int i = 0; i < 2; ++i)
        cameras[static_cast<std::size_t>(i)] = std::move(*drivers::laboratory::LabCamera::open(client, i));
    }
    if (auto next = cameras[0]->poll()) left = std::move(next);
    if (auto next = cameras[1]->poll()) right = std::move(next);
  }
  stop = true;
  process.join();
  ASSERT_TRUE(left && right);
  EXPECT_EQ(client->cameras(), 2);
  EXPECT_EQ(left->frame, right->frame);
  EXPECT_EQ(left->mid_exposure, right->mid_exposure);
  EXPECT_EQ(left->rgb.front(), 60);   // fx 560
  EXPECT_EQ(right->rgb.front(), 58);  // fx 558
}

TEST(WorldProcess, PicturesThatCannotBeDrawnAreToldOnceAndTheArmGoesOn) {
  WorldProcessOptions options;
  options.name = "world-process-fault";
  const ScratchFolder folder;
  options.folder = folder.path();
  options.make_renderer = []() -> RenderView { throw std::runtime_error("no display and no EGL"); };
  options.seconds = 2.0;
  const LogCapture told;
  const std::atomic<bool> stop{false};
  const auto report = run_world(config::reference_world(), options, stop);
  ASSERT_TRUE(report) << report.error().message;
  const auto lines = told.lines();
  EXPECT_EQ(std::count_if(lines.begin(), lines.end(),
                          [](const LogLine& line) {
                            return line.text ==
                                   "world: the camera's picture cannot be drawn: no display and no EGL; arm "
                                   "and tracker go on without pictures";
                          }),
            1)
      << told.text();
  EXPECT_EQ(report->picture_fault, "no display and no EGL");
  EXPECT_EQ(report->images, 0u);
  EXPECT_GT(report->ticks, 200u);  // it is looked for every hundred
}

}  // namespace
}  // namespace palpate::sim
