// The graphics server as a process, without pixels: a physics side that answers over its socket, and devices that stand
// still.
#include "palpate/server/session/graphics_process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

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
