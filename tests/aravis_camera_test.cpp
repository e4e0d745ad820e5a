// The Aravis driver against a pretended camera in the network of this machine that shows the simulated
// laboratory.
#include <gtest/gtest.h>
#include <time.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <thread>

#include "drivers/cameras/aravis_source.h"
#include "drivers/cameras/camera_choice.h"
#include "palpate/core/random.h"
#include "palpate/time/clock.h"
#include "palpate/time/clock_model.h"
#include "tests/fake_camera_clock.h"
#include "tests/fake_network_camera.h"
#include "tests/rendered_views.h"

namespace palpate::drivers::cameras {
namespace {

class OneAtATime : public testing::Environment {
 public:
  void SetUp() override { turn_.emplace(); }
  void TearDown() override { turn_.reset(); }

 private:
  std::optional<NetworkCameraTurn> turn_;
};
[[maybe_unused]] const auto* const one_at_a_time = testing::AddGlobalTestEnvironment(new OneAtATime);

constexpr const char* kSerial = "Palpate7";
const std::string kName = std::string("Aravis-Fake-") + kSerial;

const std::vector<FakeNetworkCamera::Picture>& shown() {
  static const auto pictures = rendered_views(3, false);
  return pictures;
}

void until(const std::function<bool()>& condition, const std::string& what) {
  const auto begun = std::chrono::steady_clock::now();
  while (!condition()) {
    ASSERT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(30)) << what;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

device::CameraImage next_image(LiveCamera& camera) {
  std::optional<device::CameraImage> image;
  until([&] { return (image = camera.poll()).has_value(); }, "a picture");
  return image.value_or(device::CameraImage{});
}

CameraRequest request(std::string format = "") {
  // By address: where a machine has several networks, a name may be answered by way of one that pictures of
  // 127.0.0.1 do not take.
  CameraRequest result{{Kind::aravis, "127.0.0.1"}, {}};
  result.settings.width = FakeNetworkCamera::kWidth, result.settings.height = FakeNetworkCamera::kHeight;
  result.settings.rate_hz = 25.0;
  result.settings.exposure_s = 0.008;
  result.settings.pixel_format = std::move(format);
  return result;
}

// Which of the pictures shown agrees with this one at every place and channel that the format carries there.
int which(const device::CameraImage& image, const std::function<bool(int x, int y, int c)>& carried,
          const std::function<int(int c)>& source) {
  for (std::size_t i = 0; i < shown().size(); ++i) {
    bool same = true;
    for (int y = 1; y < image.height - 1 && same; ++y)
      for (int x = 1; x < image.width - 1 && same; ++x)
        for (int c = 0; c < 3; ++c) {
          const auto at = static_cast<std::size_t>(3 * (y * image.width + x));
          if (carried(x, y, c) && image.rgb[at + static_cast<std::size_t>(c)] !=
                                      shown()[i][at + static_cast<std::size_t>(source(c))])
            same = false;
        }
    if (same) return static_cast<int>(i);
  }
  return -1;
}

TEST(AravisCamera, PicturesArriveToTheLastBitInEveryFormat) {
  const FakeNetworkCamera pretended(kSerial, shown());
  const auto all = [](int, int, int) { return true; };
  const auto own = [](int c) { return c; };
  const std::pair<const char*, ArvPixelFormat> bayer[] = {{"BayerRG8", ARV_PIXEL_FORMAT_BAYER_RG_8},
                                                          {"BayerGR8", ARV_PIXEL_FORMAT_BAYER_GR_8},
                                                          {"BayerGB8", ARV_PIXEL_FORMAT_BAYER_GB_8},
                                                          {"BayerBG8", ARV_PIXEL_FORMAT_BAYER_BG_8}};
  const auto check = [&](const char* format, const auto& carried, const auto& source) {
    auto camera = open_camera(request(format));
    ASSERT_TRUE(camera) << camera.error().message;
    EXPECT_EQ(name_of((*camera)->facts().format), format);
    EXPECT_EQ((*camera)->facts().serial, kSerial);
    std::set<int> seen;
    std::uint64_t frame = 0;
    until(
        [&] {
          const auto image = next_image(**camera);
          EXPECT_GT(image.frame, frame);
          frame = image.frame;
          const int found = which(image, carried, source);
          EXPECT_GE(found, 0) << format << ", frame " << image.frame;
          seen.insert(found);
          return seen.size() == shown().size();
        },
        "every picture");
  };
  check("RGB8", all, own);
  check("Mono8", all, [](int) { return 1; });
  for (const auto& [name, code] : bayer)  // where a pattern has a channel, filling in leaves it alone
    check(
        name, [format = code](int x, int y, int c) { return FakeNetworkCamera::channel(format, x, y) == c; },
        own);
}

// The pretended camera's clock is CLOCK_REALTIME and the host's is CLOCK_MONOTONIC: their difference is known.
std::int64_t wall_ns() {
  timespec wall{};
  clock_gettime(CLOCK_REALTIME, &wall);
  return wall.tv_sec * 1'000'000'000LL + wall.tv_nsec;
}
std::int64_t lead_ns() {  // of the camera's clock
  const std::int64_t before = MonotonicClock<GraphicsClock>::monotonic_ns(), wall = wall_ns();
  return wall - (before + MonotonicClock<GraphicsClock>::monotonic_ns()) / 2;
}

// How long after mid-exposure the driver says that it was, for twenty pictures that are on their way for 30 to 150 ms.
std::vector<double> told_late_ms() {
  std::uint64_t number = 0;
  Random random(4, "ways");
  const FakeNetworkCamera pretended(kSerial, [&] {
    const auto ms = static_cast<std::int64_t>(random.uniform(30.0, 150.0));
    return FakeNetworkCamera::Shown{&shown()[0], static_cast<std::uint64_t>(wall_ns()), ++number,
                                    [ms] { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }};
  });
  auto camera = open_camera(request("Mono8"));
  EXPECT_TRUE(camera) << camera.error().message;
  std::vector<double> late;
  const std::int64_t lead = lead_ns();
  while (late.size() < 20) {
    const auto image = next_image(**camera);
    const std::int64_t told = MonotonicClock<GraphicsClock>::monotonic_ns() - image.waited.count();
    late.push_back(1e-6 * static_cast<double>(told - (image.mid_exposure.ns() - lead)));
  }
  return late;
}

TEST(AravisCamera, IsAskedForItsClockSoThatTheWayOfAPictureDoesNotCount) {
  auto late_ms = told_late_ms();
  std::sort(late_ms.begin(), late_ms.end());
  // A busy machine may hold this test up after it has asked: that looks late, and never early.
  EXPECT_GT(late_ms.front(), -10.0);
  EXPECT_LT(late_ms[late_ms.size() / 2], 10.0);
}

TEST(AravisCamera, WithoutALatchAStampBelongsToTheMomentOfArrival) {
  set_fake_camera_clock({});
  for (const double late_ms : told_late_ms()) EXPECT_GE(late_ms, 25.0);
  set_fake_camera_clock([] { return static_cast<std::uint64_t>(wall_ns()); });
}

TEST(AravisCamera, StampsLeadToTheHostsTimeWithinWhatTheEstimatorStates) {
  const FakeNetworkCamera pretended(kSerial, shown());
  auto camera = open_camera(request("Mono8"));
  ASSERT_TRUE(camera) << camera.error().message;
  const MonotonicClock<GraphicsClock> clock;
  ClockEstimator<CameraClock, GraphicsClock> estimator;
  const std::int64_t lead = lead_ns();
  std::int64_t least_delay = std::numeric_limits<std::int64_t>::max();
  Instant<CameraClock> stamp;
  auto looked = clock.now();
  for (int pictures = 0; pictures < 100;) {
    const auto image = (*camera)->poll();
    const auto now = clock.now();
    if (image) {
      estimator.add(image->mid_exposure, now, now - looked);
      stamp = image->mid_exposure;
      least_delay = std::min(least_delay, now.ns() - (stamp.ns() - lead));
      ++pictures;
    }
    looked = now;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_LT(std::abs(lead_ns() - lead), 1'000'000) << "the machine's clock was set meanwhile";
  // What the estimate holds beyond the truth is the smallest delay, 4 ms of exposure taken off: the stamp is
  // its middle and the pretended camera waits for no light.
  const std::int64_t excess = estimator.model().to(stamp).ns() - (stamp.ns() - lead);
  const std::int64_t stated = estimator.model().uncertainty(stamp).count();
  EXPECT_GE(excess, -4'000'000 - stated);
  EXPECT_LE(excess, least_delay + stated);
  RecordProperty("excess_us", static_cast<int>(excess / 1000));
  RecordProperty("stated_us", static_cast<int>(stated / 1000));
  EXPECT_EQ(estimator.restarts(), 0);
}

TEST(AravisCamera, IsMissedWhenItsPlugIsPulledAndComesBackByItself) {
  std::optional<FakeNetworkCamera> pretended(std::in_place, kSerial, shown());
  auto camera = open_camera(request());
  ASSERT_TRUE(camera) << camera.error().message;
  const auto first = next_image(**camera);
  EXPECT_FALSE((*camera)->status().health);
  pretended.reset();
  std::optional<device::HealthReport> health;
  until([&] { return (health = (*camera)->status().health).has_value(); }, "the loss");
  EXPECT_NE(health->words.find("see to its cable and power"), std::string::npos) << health->words;
  EXPECT_NE(health->end.find("works again"), std::string::npos) << health->end;
  pretended.emplace(kSerial, shown());
  until([&] { return !(*camera)->status().health; }, "the return");
  EXPECT_GT(next_image(**camera).frame, first.frame);
  EXPECT_GE((*camera)->status().times_opened, 2u);
}

TEST(AravisCamera, IsPretendedOnlyWhereItIsHeard) {
  const FakeNetworkCamera pretended(kSerial, shown());
  EXPECT_THROW(FakeNetworkCamera("Palpate9", shown()), std::runtime_error);
}

TEST(AravisCamera, IsListedAndSaysWhatItCannotDo) {
  const FakeNetworkCamera pretended(kSerial, shown());
  const auto found = list_aravis();
  const auto it =
      std::find_if(found.begin(), found.end(), [](const auto& look) { return look.name == kName; });
  ASSERT_NE(it, found.end());
  EXPECT_EQ(it->serial, kSerial);
  EXPECT_EQ(it->address, "127.0.0.1");
  const auto refusal = [](const std::function<void(CameraRequest&)>& change) {
    auto asked = request();
    change(asked);
    const auto camera = open_camera(asked);
    return camera ? std::string("accepted") : camera.error().message;
  };
  const auto has = [](const std::string& message, const char* words) {
    EXPECT_NE(message.find(words), std::string::npos) << message;
    EXPECT_EQ(message.find("camera aravis:"), 0u) << message;
  };
  has(refusal([](CameraRequest& w) { w.choice.which = "Aravis-Fake-Nobody"; }), "no such camera answers");
  has(refusal([](CameraRequest& w) { w.settings.width = 4096; }), "4096x480 are asked for");
  has(refusal([](CameraRequest& w) { w.settings.pixel_format = "BGR8"; }), "and BGR8 is expected");
  has(refusal([](CameraRequest& w) { w.settings.gain = 1000.0; }), "gain 1000");
  const auto holder = open_camera(request());
  ASSERT_TRUE(holder) << holder.error().message;
  has(refusal([](CameraRequest&) {}), "another program");
}

}  // namespace
}  // namespace palpate::drivers::cameras
