#include "palpate/server/physics/physics_process.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <thread>

#include "applications/pingpong/specification.h"
#include "drivers/laboratory/channel.h"
#include "drivers/laboratory/driver.h"
#include "palpate/core/log.h"
#include "palpate/server/physics/rig_for_tests.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/time/clock.h"
#include "palpate/transport/zmq_engine.h"
#include "tests/own_run_directory.h"

namespace palpate::server::physics {
namespace {

// A laboratory of an arm at rest, in a run folder of its own. No tracker, no camera: physics needs neither.
class RestingArm : public testing::Test {
 protected:
  RestingArm() {
    auto server = drivers::laboratory::LabServer::open("bench", {.cameras = 1, .width = 16, .height = 16});
    if (!server) throw std::runtime_error(server.error().message);
    thread_ = std::thread([this, laboratory = std::move(*server)] {
      const MonotonicClock<ArmClock> clock;
      while (!closed_) {
        device::ArmSample sample;
        sample.stamp = clock.now();
        sample.joints = {0.1, 0.5, 0.3};
        laboratory->publish_arm(sample);
        laboratory->heartbeat();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
  }
  ~RestingArm() override { close_laboratory(); }
  void close_laboratory() {
    closed_ = true;
    if (thread_.joinable()) thread_.join();
  }

  static PhysicsProcessOptions options() {
    PhysicsProcessOptions made;
    made.rig = rig_of_table_and_wall();
    made.applications = {applications::pingpong::specification()};
    made.scene = *sim::config::scene_of(sim::config::reference_world(),
                                        {applications::pingpong::specification()}, "pingpong");
    drivers::laboratory::add_to(made.drivers);
    made.arm.uri = "lab:bench";
    made.real_time = false;  // a test does not take the machine's cores away
    return made;
  }

 private:
  OwnRunDirectory run_directory_;
  std::atomic<bool> closed_{false};
  std::thread thread_;
};

TEST_F(RestingArm, TheProcessAnswersClientsAndEndsWithItsLaboratory) {
  Expected<Json> result = Json();
  std::thread process([&] { result = run_physics_process(options()); });
  const MonotonicClock<GraphicsClock> clock;
  auto link = transport::connect_states(*transport::default_endpoint(), clock, "test");
  EXPECT_TRUE(link);
  const auto patience = std::chrono::seconds(120);  // an answer ends the wait
  const auto start = clock.now();
  bool answered = false;
  for (std::uint64_t number = 1; link && !answered && clock.now() - start < patience; ++number) {
    (*link)->poll();
    if ((*link)->description()) (*link)->request(number, Instant<PhysicsClock>{Duration(clock.now().ns())});
    answered = (*link)->newest() && (*link)->newest()->reply.answer.usable();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_TRUE(answered);
  if (answered) {
    EXPECT_EQ((*link)->description()->surfaces.size(), 2u);
    EXPECT_EQ((*link)->role(), transport::Role::operator_);
    EXPECT_GT((*link)->newest()->reply.answer.state.tick, 0u);
  }
  close_laboratory();
  process.join();
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message.find("laboratory 'bench'"), std::string::npos) << result.error().message;
}

TEST_F(RestingArm, ItsFiguresTellOfBothLoops) {
  auto asked = options();
  asked.seconds = 1.0;
  const LogCapture told;
  const auto result = run_physics_process(asked);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_GT((*result)["haptic"]["ticks"].get<std::uint64_t>(), 0u);
  EXPECT_GT((*result)["physics"]["ticks"].get<std::uint64_t>(), 0u);
  EXPECT_EQ(told.text().find("physics: answers graphics servers at ipc://"), 0u) << told.text();
  EXPECT_EQ((*result)["force"]["blows"], 0);
  EXPECT_TRUE((*result)["force"].contains("trips"));
}

TEST_F(RestingArm, WithoutLaboratoryOrSurfacesItDoesNotStart) {
  auto elsewhere = options();
  elsewhere.arm.uri = "lab:elsewhere";
  EXPECT_FALSE(run_physics_process(elsewhere));
  auto strange = options();
  strange.arm.uri = "elsewhere";
  EXPECT_EQ(run_physics_process(strange).error().message, "--arm: is 'elsewhere'; lab is expected");
  auto bare = options();
  bare.rig.surfaces.clear();
  const auto refusal = run_physics_process(bare);
  ASSERT_FALSE(refusal);
  EXPECT_NE(refusal.error().message.find("'table'"), std::string::npos) << refusal.error().message;
  auto empty = options();
  empty.applications = {};
  const auto unknown = run_physics_process(empty);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().message, "application 'pingpong' is not known; there are: none");
}

}  // namespace
}  // namespace palpate::server::physics
