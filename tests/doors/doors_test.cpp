// Each door alone, between a laboratory of the test's own and the driver that a real device of the kind would have.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

#include "drivers/cameras/camera_choice.h"
#include "drivers/openhaptics/arm.h"
#include "drivers/openigtlink/driver.h"
#include "palpate/time/clock.h"
#include "tests/doors/arm_door.h"
#include "tests/doors/camera_door.h"
#include "tests/doors/tracker_door.h"
#include "tests/fake_network_camera.h"
#include "tests/scratch_folder.h"

namespace palpate::doors {
namespace {

using drivers::laboratory::LabClient;
using drivers::laboratory::LabServer;

std::int64_t door_now_ns() { return MonotonicClock<TrueTime>::monotonic_ns(); }

// A laboratory of which `tick` publishes what the test wants, each millisecond.
class DoorTest : public testing::Test {
 protected:
  DoorTest() {
    drivers::laboratory::LabSettings settings;
    settings.folder = scratch_.path();
    auto opened = LabServer::open("doors", settings);
    if (!opened) throw std::runtime_error(opened.error().message);
    server_ = std::move(*opened);
  }
  ~DoorTest() override {
    stop_ = true;
    if (door_.joinable()) door_.join();
    if (laboratory_.joinable()) laboratory_.join();
  }
  void run(std::function<void(std::int64_t)> tick) {
    laboratory_ = std::thread([this, tick = std::move(tick)] {
      MonotonicClock<TrueTime> clock;
      auto next = clock.now();
      for (std::int64_t n = 0; !stop_; ++n) {
        clock.sleep_until(next = std::max(next + std::chrono::milliseconds(1), clock.now()));
        server_->heartbeat();
        tick(n);
      }
    });
  }
  // `serve(laboratory, ready)` in a thread of its own; returns when it is ready.
  template <typename Serve>
  void open(Serve serve) {
    is_ready = false;
    server_->heartbeat();
    auto client = LabClient::open("doors", scratch_.path());
    if (!client) throw std::runtime_error(client.error().message);
    door_ = std::thread([serve, laboratory = *client] {
      const auto done = serve(laboratory, [] { is_ready = true; });
      EXPECT_TRUE(done.has_value()) << (done ? "" : done.error().message);
    });
    comes_true([] { return is_ready.load(); });
  }
  static void comes_true(const std::function<bool()>& condition) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!condition()) {
      ASSERT_LT(std::chrono::steady_clock::now(), until);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  static inline std::atomic<bool> is_ready{false};
  ScratchFolder scratch_;
  std::unique_ptr<LabServer> server_;
  std::atomic<bool> stop_{false};
  std::thread laboratory_, door_;
};

device::TrackerSample tracked(std::int64_t n, device::MarkerId marker) {
  device::TrackerSample sample;
  sample.stamp = {Duration(n * 1'000'003 - 5'000'000'000)};  // below 0 at first, as the reference world's
  sample.marker = marker;
  sample.seen = n % 50 != 0;
  sample.rotation =
      Quaternion(Eigen::AngleAxisd(0.001 * static_cast<double>(n % 1000), Vector3(1, 2, 3).normalized()));
  sample.translation = {0.1 + 1e-4 * static_cast<double>(n % 1000), -1.4,
                        1.7 + 0.01 * static_cast<double>(marker)};
  return sample;
}

TEST_F(DoorTest, TheTrackersPosesComeThroughEqualWithItsOwnStamps) {
  static constexpr std::uint16_t kPort = 18977;
  run([this](std::int64_t n) {
    if (n % 10 != 0) return;
    for (const auto marker :
         {device::MarkerId::tip_marker, device::MarkerId::camera_marker, device::MarkerId::pointer})
      server_->publish_tracker(tracked(n, marker));
  });
  open([this](const auto& laboratory, auto ready) { return serve_tracker(laboratory, kPort, stop_, ready); });
  device::DriverRegistry drivers;
  drivers::openigtlink::add_to(drivers);
  auto tracker = drivers.open(device::TrackerRequest{"igtl://127.0.0.1:" + std::to_string(kPort), {}});
  ASSERT_TRUE(tracker.has_value());
  std::vector<device::TrackerSample> heard;
  comes_true([&] {
    for (const auto& sample : (*tracker)->device().poll()) heard.push_back(sample);
    return heard.size() >= 300;
  });
  std::map<device::MarkerId, std::int64_t> last;
  for (const auto& sample : heard) {
    const std::int64_t n = std::llround((sample.stamp.seconds() - 1000.0 + 5.0) / 1.000003e-3);
    const auto sent = tracked(n, sample.marker);
    EXPECT_TRUE(sent.seen) << "a hidden marker is not sent";
    EXPECT_NEAR(static_cast<double>((sample.stamp - sent.stamp).count()), 1e12,
                2.0);                                                 // ns; the door's own start
    EXPECT_LT((sample.translation - sent.translation).norm(), 3e-7);  // float32 on the wire
    EXPECT_LT(sample.rotation.angularDistance(sent.rotation), 1e-6);
    if (const auto before = last.find(sample.marker); before != last.end()) {
      EXPECT_EQ(n - before->second, (n - 10) % 50 == 0 ? 20 : 10) << "none is lost";
    }
    last[sample.marker] = n;
  }
  EXPECT_EQ(last.size(), 3u);
}

// When each reading of the laboratory's arm was published, by its number.
class Published {
 public:
  void add(std::int64_t n) {
    const std::lock_guard lock(guard_);
    when_[n] = door_now_ns();
  }
  std::map<std::int64_t, std::int64_t> all() const {
    const std::lock_guard lock(guard_);
    return when_;
  }

 private:
  mutable std::mutex guard_;
  std::map<std::int64_t, std::int64_t> when_;
};

// The driver with the stand-in's arm at the cable.
std::unique_ptr<drivers::openhaptics::OpenHapticsArm> arm_at(const std::string& cable) {
  setenv("HD_STUB_ARM", cable.c_str(), 1);
  drivers::openhaptics::ArmSettings settings;
  settings.library = HD_STUB_FILE;
  settings.loop.watchdog_s = 10.0;  // a busy machine is no fault of the door
  settings.loop.ramp_s = 0.01;
  auto arm = drivers::openhaptics::OpenHapticsArm::open(settings);
  if (!arm) throw std::runtime_error(arm.error().message);
  return std::move(*arm);
}

TEST_F(DoorTest, TheArmsReadingsComeEachMillisecondAndForcesReachItsMotors) {
  const std::string cable = (scratch_ / "arm").string();
  const auto published = std::make_shared<Published>();
  run([this, published](std::int64_t n) {
    device::ArmSample sample;
    sample.stamp = {Duration(n)};
    sample.joints = {0.1, 0.5, 1e-9 * static_cast<double>(n)};
    sample.gimbal = {0.3, -0.4, 1.1};
    published->add(n);
    server_->publish_arm(sample);
  });
  open([&](const auto& laboratory, auto ready) { return serve_arm(laboratory, cable, stop_, ready); });
  auto arm = arm_at(cable);
  std::map<std::int64_t, std::int64_t> read;  // the driver's stamp, of each number
  const Vector3 wanted(0.3, -0.2, 0.5);
  const auto begun = door_now_ns();
  const std::uint64_t cycles_before = arm->status().cycles;
  bool felt = false;
  comes_true([&] {
    arm->command(wanted);
    const auto sample = arm->read();
    if (sample.joints.allFinite() && sample.joints[0] != 0.0) {
      EXPECT_NEAR(sample.joints[0], 0.1, 1e-12);
      EXPECT_LT((sample.gimbal - Vector3(0.3, -0.4, 1.1)).norm(), 1e-7);
      read.emplace(std::llround(sample.joints[2] * 1e9), sample.stamp.ns());
    }
    const auto force = server_->take_force();
    felt = felt || (force && !force->let_go && (force->force - wanted).norm() < 1e-9);
    return door_now_ns() - begun > 3'000'000'000;
  });
  EXPECT_TRUE(felt) << "the force that was commanded";
  const auto when = published->all();
  const auto there =
      std::count_if(when.begin(), when.end(), [&](const auto& one) { return one.second >= begun; });
  const auto cycles = static_cast<double>(arm->status().cycles - cycles_before);
  EXPECT_GT(cycles, 0.5 * static_cast<double>(there)) << "a busy machine may pass some over";
  EXPECT_LT(cycles, 1.01 * static_cast<double>(there) + 2.0) << "a cycle is one of the arm's";
  std::vector<double> late;
  for (const auto& [n, stamp] : read) late.push_back(1e-3 * static_cast<double>(stamp - when.at(n)));
  std::sort(late.begin(), late.end());
  ASSERT_GT(late.size(), 100u);
  std::printf(
      "from the arm's reading to the driver's stamp: median %.0f us, 99 %% %.0f us, least %.0f us; %.0f of "
      "%ld\n",
      late[late.size() / 2], late[late.size() * 99 / 100], late.front(), cycles, static_cast<long>(there));
  EXPECT_GE(late.front(), 2000.0) << "none goes out before its time";
  EXPECT_LT(late[late.size() / 2], 4000.0);
  arm.reset();
  comes_true([&] {
    const auto force = server_->take_force();
    return force && force->force == Vector3::Zero();
  });
}

TEST_F(DoorTest, ThePicturesComeThroughWithTheCamerasStamps) {
  const NetworkCameraTurn turn;
  run([this](std::int64_t n) {
    if (n % 33 != 0) return;
    device::CameraImage image{
        {Duration(7'000'000'000 + n * 1'000'000 + n)}, static_cast<std::uint64_t>(n / 33 + 5), 640, 480, {}};
    image.rgb.assign(std::size_t{3} * 640 * 480, static_cast<std::uint8_t>(n % 251));
    image.rgb.front() = 1;
    server_->publish_image(image);
  });
  open([this](const auto& laboratory, auto ready) {
    return serve_camera(laboratory, {"PalpateDoor", 0.008, 30.0}, stop_, ready);
  });
  drivers::cameras::CameraRequest request{{drivers::cameras::Kind::aravis, "127.0.0.1"}, {}};
  request.settings.pixel_format = "RGB8";
  auto camera = drivers::cameras::open_camera(request);
  ASSERT_TRUE(camera.has_value()) << camera.error().message;
  EXPECT_NEAR((*camera)->facts().exposure_s, 0.008, 1e-9);
  std::vector<device::CameraImage> seen;
  comes_true([&] {
    if (auto image = (*camera)->poll()) seen.push_back(std::move(*image));
    return seen.size() >= 40;
  });
  std::int64_t before = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const std::int64_t n =
        std::llround(static_cast<double>(seen[i].mid_exposure.ns() - 7'000'000'000) / 1'000'001.0);
    EXPECT_EQ(seen[i].mid_exposure.ns(), 7'000'000'000 + n * 1'000'001)
        << "the camera's stamp, to the nanosecond";
    ASSERT_EQ(seen[i].width, 640);
    EXPECT_EQ(seen[i].rgb[0], 1);
    EXPECT_EQ(seen[i].rgb.back(), n % 251) << "the picture that was stamped so";
    if (i > 0) {
      EXPECT_EQ(static_cast<std::int64_t>(seen[i].frame - seen[i - 1].frame), (n - before) / 33)
          << "frames are counted";
    }
    before = n;
  }
}

}  // namespace
}  // namespace palpate::doors
