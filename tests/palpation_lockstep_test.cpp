#include <gtest/gtest.h>

#include "applications/palpation/palpation.h"
#include "applications/palpation/record.h"
#include "applications/palpation/specification.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/lockstep/lockstep_play.h"
#include "palpate/sim/truth_rig.h"

namespace palpate {
namespace {

// Easily felt nodules in coarse elements, which are ready in seconds; searched with a wide grid.
scene::SceneDescription palpation_scene(const sim::Simulator& world, const rig::Rig& rig,
                                        const scene::ApplicationRegistry& applications) {
  auto settings = world.file();
  for (const auto& [name, value] : std::initializer_list<std::pair<const char*, std::vector<double>>>{
           {"palpation.nodules", {1.0, 1.0}},
           {"palpation.nodule_mm", {19.0, 20.0}},
           {"palpation.nodule_depth_mm", {3.0, 3.5}},
           {"palpation.nodule_ratio", {20.0, 20.0}},
           {"palpation.element_mm", {14.0}},
           {"palpation.trainee_spacing_mm", {14.0}},
           {"palpation.trainee_weber", {0.05}}})
    settings.settings.set(name, value);
  return server::physics::scene_from_rig(rig, *sim::config::scene_of(settings, applications, "palpation"));
}

// The trainee in front of the picture, through cameras, network, clocks and motors, and back into the picture: twice,
// to the same end.
TEST(PalpationInLockstep, TheTraineeFindsANoduleThroughTheWholeSystem) {
  const scene::ApplicationRegistry applications{applications::palpation::specification()};
  Json first;
  for (int run = 0; run < 2; ++run) {
    sim::Simulator world(sim::config::reference_world(applications), 5);
    const rig::Rig rig = sim::truth_rig(world);
    const auto scene = palpation_scene(world, rig, applications);
    sim::lockstep::LockstepOptions options;
    options.applications = applications;
    options.seconds = 24.0;
    options.seed = 5;
    applications::palpation::PalpationRecord record(scene);
    options.watch = [&record](const scene::SceneState& state) { record.add_state(state); };
    const auto play = sim::lockstep::play_in_lockstep(world, rig, scene, options, {}, {});
    ASSERT_TRUE(play) << play.error().message;
    const Json summary = record.summary()["palpation"];
    EXPECT_TRUE(summary["over"].get<bool>()) << "the stylus is put away within the play";
    EXPECT_EQ(summary["found"], 1);
    EXPECT_LT(summary["force_p95_n"].get<double>(), 1.5);
    EXPECT_LT(summary["energy_created_j"].get<double>(), 1e-4);
    EXPECT_GT(summary["presses"].get<int>(), 15);
    EXPECT_EQ(play->haptic.fault_ticks, 0u);
    if (run == 0) first = summary;
    EXPECT_EQ(first.dump(), summary.dump());
  }
}

}  // namespace
}  // namespace palpate
