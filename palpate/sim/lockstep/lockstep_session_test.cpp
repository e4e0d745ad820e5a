#include "palpate/sim/lockstep/lockstep_session.h"

#include <gtest/gtest.h>

#include "applications/touch/record.h"
#include "applications/touch/specification.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/lockstep/play_figures.h"
#include "palpate/sim/truth_rig.h"
#include "tests/scratch_folder.h"

namespace palpate::sim::lockstep {
namespace {

SessionRequest touch_request() {
  SessionRequest request;
  request.applications = {applications::touch::specification()};
  request.application = "touch";
  request.world = config::reference_world(request.applications);
  request.seed = 5;
  request.seconds = 4.0;
  return request;
}

TEST(LockstepSession, FiguresAreThoseOfThePlay) {
  const SessionRequest request = touch_request();
  const auto told = run_session(request);
  ASSERT_TRUE(told) << told.error().message;
  Simulator world(request.world, request.seed);
  const rig::Rig rig = truth_rig(world);
  const auto scene = server::physics::scene_from_rig(
      rig, *config::scene_of(request.world, request.applications, request.application));
  applications::touch::TouchRecord record;
  LockstepOptions options;
  options.applications = request.applications;
  options.seconds = request.seconds;
  options.seed = request.seed;
  options.watch = [&record](const scene::SceneState& state) { record.add_state(state); };
  const auto play = play_in_lockstep(world, rig, scene, options, {}, {});
  ASSERT_TRUE(play) << play.error().message;
  EXPECT_EQ(told->figures["exchange"].dump(), exchange_figures(*play).dump());
  EXPECT_EQ(told->figures["force"].dump(), force_figures(play->haptic, request.world.arm.max_force).dump());
  EXPECT_EQ(told->figures["touch"].dump(), record.summary()["touch"].dump());
  EXPECT_EQ(told->figures["rig"], "truth");
  EXPECT_EQ(told->figures["settings"]["touch.stiffness_n_m"], 600.0);
  int begun = 0;
  for (const auto& event : told->figures["events"]) begun += event["event"] == "touch-begins" ? 1 : 0;
  EXPECT_EQ(begun, told->figures["touch"]["touches"].get<int>());
  EXPECT_GT(begun, 0);
}

TEST(LockstepSession, ItsRecordingHoldsEachTickThatCountsAndChangesNothing) {
  const ScratchFolder folder;
  SessionRequest request = touch_request();
  request.seconds = 2.0;
  const auto alone = run_session(request);
  request.record = folder.path() / "play.mcap";
  const auto recorded = run_session(request);
  ASSERT_TRUE(alone && recorded);
  EXPECT_EQ(recorded->figures.dump(), alone->figures.dump());
  const auto again = run_session(request);
  ASSERT_FALSE(again) << "the file is there";
  EXPECT_NE(again.error().message.find("play.mcap"), std::string::npos);
}

TEST(LockstepSession, TellsOfARigThatIsOfAnotherLaboratory) {
  SessionRequest request = touch_request();
  request.seconds = 0.5;
  for (const std::uint64_t seed : {5, 6}) {
    const Simulator other(request.world, seed);
    request.rig = truth_rig(other);
    // As a calibration writes it: its first offset is zero, and its base turned instead.
    const ArmTruth arm = arm_with_first_offset_zero(other.truth());
    request.rig->arm->correction = arm.joints;
    request.rig->arm->X_world_base = arm.X_world_base;
    const auto told = run_session(request);
    ASSERT_TRUE(told) << told.error().message;
    bool warned = false;
    for (const auto& line : told->lines) warned = warned || line.about == "rig";
    EXPECT_EQ(warned, seed != request.seed) << seed;
  }
}

TEST(LockstepSession, AnApplicationMayNotTakeTheSystemsKeys) {
  SessionRequest request = touch_request();
  request.seconds = 0.2;
  auto bold = applications::touch::specification();
  struct Record : scene::PlayRecord {
    Json summary() const override { return {{"force", 1}}; }
  };
  bold.make_record = [](const scene::SceneDescription&) { return std::make_unique<Record>(); };
  request.applications = {bold};
  const auto told = run_session(request);
  ASSERT_FALSE(told);
  EXPECT_NE(told.error().message.find("'force'"), std::string::npos);
}

TEST(LockstepSession, SettingsOutOfRangeAreRefusedBeforeAnythingIsPlayed) {
  SessionRequest request = touch_request();
  request.world.settings.set("touch.stiffness_n_m", 1e9);
  const auto told = run_session(request);
  ASSERT_FALSE(told);
  EXPECT_EQ(told.error().kind, Error::Kind::wrong_use);
  EXPECT_EQ(told.error().message.find("touch.stiffness_n_m: is 1000000000"), 0u) << told.error().message;
}

}  // namespace
}  // namespace palpate::sim::lockstep
