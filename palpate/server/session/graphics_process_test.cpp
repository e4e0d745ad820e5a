// The graphics server as a process, without pixels: a physics side that answers over its socket, and devices that stand
// still.
#include "palpate/server/session/graphics_process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <optional>
#include <thread>

#include "applications/pingpong/specification.h"
#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "palpate/server/physics/physics_loops.h"
#include "palpate/server/session/devices_for_tests.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/transport/local_endpoint.h"
#include "tests/own_run_directory.h"

namespace palpate::server::session {
namespace {

class GraphicsProcessRun : public testing::Test {
 protected:
  GraphicsProcessRun() {
    options_.rig = StillLaboratory::rig();
    options_.applications = {applications::pingpong::specification()};
    options_.world = sim::config::reference_world();
    options_.drivers = laboratory_.drivers();
    options_.stand_in = "still";
    options_.pixels = Pixels::unseen;
    options_.seconds = 2.0;
    options_.ready = [this] { ++ready_; };
  }
  ~GraphicsProcessRun() override { loops_.reset(); }
  void start_physics() {
    physics::PhysicsSetup setup;
    setup.rig = StillLaboratory::rig();
    setup.applications = {applications::pingpong::specification()};
    setup.scene = *sim::config::scene_of(options_.world, setup.applications, "pingpong");
    setup.drivers = its_own_.drivers();
    setup.arm.uri = "still";
    auto side = physics::PhysicsSide::open(setup);
    ASSERT_TRUE(side) << side.error().message;
    side_ = std::move(*side);
    const auto served = side_->serve(*transport::default_endpoint(), clock_);
    ASSERT_TRUE(served) << served.error().message;
    loops_.emplace(*side_, clock_, physics::LoopRates{.real_time = false});
  }

  OwnRunDirectory run_directory_;
  LogCapture told_;
  int ready_ = 0;
  StillLaboratory laboratory_, its_own_;
  GraphicsProcessOptions options_;
  MonotonicClock<PhysicsClock> clock_;
  std::unique_ptr<physics::PhysicsSide> side_;
  std::optional<physics::PhysicsLoops> loops_;
};

TEST_F(GraphicsProcessRun, TakesEachImageAsksForItsStateAndTellsTheFigures) {
  start_physics();
  options_.out = run_directory_.path() / "out";
  options_.player = true;
  options_.disguise_offset_s = 3.0;
  std::filesystem::create_directory(options_.out);
  const auto figures = run_graphics_process(options_);
  ASSERT_TRUE(figures) << figures.error().message;
  EXPECT_EQ(ready_, 1);
  EXPECT_NE(told_.text().find("graphics: shows pingpong of the physics server at ipc://"), std::string::npos)
      << told_.text();
  const auto frames = (*figures)["exchange"]["frames"].get<std::uint64_t>();
  EXPECT_GT(frames, 10u) << "of a hundred images, on however busy a machine";
  EXPECT_GT((*figures)["sync"]["exchanges"].get<std::uint64_t>(), 0u);
  EXPECT_LT((*figures)["sync"]["offset_error_us_p99"].get<double>(), 1e5) << "3 s are known to a tenth";
  EXPECT_EQ((*figures)["graphics"]["eyes"], 1);
  EXPECT_FALSE(figures->contains("window"));
  // Its log holds a row for each of them, and the poses are the tracker's.
  const auto log = read_file(options_.out / "realtime_frames.csv");
  ASSERT_TRUE(log) << log.error().message;
  EXPECT_EQ(static_cast<std::uint64_t>(std::count(log->begin(), log->end(), '\n')), frames + 1)
      << "with a header";
  EXPECT_GE(side_->service().counters().requests, frames / 2);
}

// Its camera lets it run until it is told: a process without an end of its own.
TEST_F(GraphicsProcessRun, GoesOnWithoutItsPhysicsServerAndFindsTheNextOne) {
  class UntilTold : public device::OpenedCamera, public device::CameraDevice {
   public:
    UntilTold(std::atomic<bool>& done, std::atomic<int>& images) : done_(done), images_(images) {}
    device::CameraDevice& device() override { return *this; }
    std::string name() const override { return "film"; }
    std::string description() const override { return "a film"; }
    Expected<void> look() override {
      if (done_) return refused("camera film: has ended");
      return {};
    }
    std::optional<device::CameraImage> poll() override {
      auto image = still_.poll();
      images_ += image ? 1 : 0;
      return image;
    }

   private:
    StillCamera still_;
    std::atomic<bool>& done_;
    std::atomic<int>& images_;
  };
  std::atomic<bool> done{false};
  std::atomic<int> images{0};
  device::Driver film;
  film.scheme = "film";
  film.summary = "a camera that ends";
  film.camera.emplace();
  film.camera->form = "film";
  film.camera->open = [&](const device::CameraRequest&) -> Expected<std::unique_ptr<device::OpenedCamera>> {
    return std::make_unique<UntilTold>(done, images);
  };
  options_.drivers.add(film);
  options_.camera = device::CameraRequest{"film", {}};
  options_.seconds = 0.0;
  start_physics();
  Expected<Json> ended;
  std::thread process([&] { ended = run_graphics_process(options_); });
  const auto soon = [&](const auto& condition) {
    for (int i = 0; i < 6000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return condition();
  };
  const auto answered = [&] { return side_->service().counters().requests > 5; };
  EXPECT_TRUE(soon(answered));
  loops_.reset();
  side_.reset();
  const int before = images;
  EXPECT_TRUE(soon([&] { return images > before + 50; })) << "a second without a server";
  start_physics();
  EXPECT_TRUE(soon(answered)) << told_.text();
  EXPECT_EQ(ready_, 1) << "it began once";
  done = true;
  process.join();
  ASSERT_FALSE(ended);
  EXPECT_NE(ended.error().message.find("camera film: has ended"), std::string::npos) << ended.error().message;
}

TEST_F(GraphicsProcessRun, WhoShowsNothingHasNoWindow) {
  options_.window = true;
  const auto none = run_graphics_process(options_);
  ASSERT_FALSE(none);
  EXPECT_EQ(ready_, 0);
}

TEST_F(GraphicsProcessRun, DevicesAreMissedBeforeThePhysicsServer) {
  options_.stand_in = "elsewhere";
  const auto none = run_graphics_process(options_);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message, "is 'elsewhere'; still is expected");
}

TEST_F(GraphicsProcessRun, AnApplicationThatIsNotKnownHereIsSaidOnceAndThePlayerCannotPlayIt) {
  start_physics();
  options_.applications = {};
  const auto figures = run_graphics_process(options_);
  ASSERT_TRUE(figures) << figures.error().message;
  EXPECT_NE(told_.text().find("application 'pingpong' is not part of this program"), std::string::npos)
      << told_.text();
  options_.player = true;
  const auto none = run_graphics_process(options_);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("'pingpong' is not known"), std::string::npos) << none.error().message;
}

}  // namespace
}  // namespace palpate::server::session
