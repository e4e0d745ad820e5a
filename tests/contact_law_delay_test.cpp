// What it changes that the force of `touch` is computed in the haptic tick: nothing but a tick of delay. The tip
// goes along a path that was recorded beforehand, pressing and stroking, whatever it feels; the same law, once
// evaluated by the haptic tick and once by the application's step, as it was before.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "applications/touch/specification.h"
#include "applications/touch/touch.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/simulator.h"
#include "palpate/sim/truth_rig.h"

namespace palpate {
namespace {

class RecordedArm : public device::ArmDevice {
 public:
  explicit RecordedArm(const std::vector<device::ArmSample>& samples) : samples_(samples) {}
  device::ArmSample read() override {
    device::ArmSample sample = samples_[next_++];
    sample.held = force_;
    return sample;
  }
  void command(const Vector3& force) override { force_ = force; }
  void let_go() noexcept override { force_.setZero(); }

 private:
  const std::vector<device::ArmSample>& samples_;
  std::size_t next_ = 0;
  Vector3 force_ = Vector3::Zero();
};

// The law in the physics loop.
class TouchInTheStep : public scene::Application {
 public:
  explicit TouchInTheStep(const scene::SceneDescription& scene) : touch_(scene) {}
  void step(Instant<PhysicsClock> now, Duration dt, const scene::TipState& tip,
            scene::SceneState& state) override {
    touch_.contact_law()->force(tip, to_seconds(dt));
    touch_.step(now, dt, tip, state);
  }
  const scene::ImpactEvent& impact() const override { return touch_.impact(); }

 private:
  void begin() override { touch_.control(scene::Control::begin); }
  void reset() override { touch_.control(scene::Control::reset); }
  applications::touch::TouchApplication touch_;
};

class Strokes : public testing::Test {
 protected:
  Strokes() : world_(sim::config::reference_world(), 1), rig_(sim::truth_rig(world_)) {
    auto settings = *sim::config::scene_of(world_.file(), {applications::touch::specification()}, "touch");
    static const auto coarse = std::make_shared<scene::TriangleMesh>(applications::touch::organ_mesh(60));
    settings.mesh = scene::MeshAsset{.mesh = coarse};
    scene_ = server::physics::scene_from_rig(rig_, settings);
    record();
  }

  // Requested forces and tips, tick by tick.
  std::vector<haptics::HapticRecord> felt_with(std::unique_ptr<scene::Application> application, bool sways) {
    RecordedArm arm(samples_);
    haptics::HapticSettings settings{.permit = haptics::ForcePermit::of_simulated_arm()};
    settings.record_s = 8.0;
    server::physics::PhysicsServer server(rig_, scene_, std::move(application), arm, settings);
    if (sways) server.control(scene::Control::begin);
    Duration now(0);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      now += std::chrono::milliseconds(1);
      server.haptic_tick({now});
      server.physics_tick({now});
    }
    return server.haptic().records();
  }

  sim::Simulator world_;
  rig::Rig rig_;
  scene::SceneDescription scene_;
  std::vector<device::ArmSample> samples_;

 private:
  void record() {
    const applications::touch::TouchApplication organ(scene_);
    const Vector3 top = organ.rest().translation + Vector3(0.0, 0.060, 0.0);
    world_.begin_play();
    for (int ms = 0; ms < 4000; ++ms) {
      const double t = 1e-3 * ms;
      device::HandTarget target;
      target.tip.m = top;
      if (t > 1.5) target.tip.m.y() -= 0.022 + 0.004 * std::sin(5.0 * t);
      if (t > 2.0) target.tip.m.x() += 0.012 * std::sin(4.0 * (t - 2.0));
      world_.hand().move_to(target);
      world_.advance_to({std::chrono::milliseconds(ms + 1)});
      samples_.push_back(world_.arm().read());
    }
  }
};

TEST_F(Strokes, TheHapticTickRequestsTheSameForceToTheLastBitOneTickEarlier) {
  const auto now = felt_with(std::make_unique<applications::touch::TouchApplication>(scene_), false);
  const auto before = felt_with(std::make_unique<TouchInTheStep>(scene_), false);
  ASSERT_EQ(now.size(), before.size());
  int felt = 0, changing = 0;
  for (std::size_t i = 0; i + 1 < now.size(); ++i) {
    ASSERT_EQ(now[i].tip, before[i].tip);
    ASSERT_EQ(now[i].requested, before[i + 1].requested) << "tick " << i;
    felt += now[i].requested != Vector3::Zero();
    changing += now[i].requested != now[i + 1].requested;
  }
  EXPECT_GT(felt, 1000) << "of 4000 ticks";
  EXPECT_GT(changing, 1000);
}

// Carried on to the tip's time by its speed, the organ is where the physics loop would have had it to some nm.
TEST_F(Strokes, OnAnOrganThatMovesTheForceIsTheSameToAThousandth) {
  const auto now = felt_with(std::make_unique<applications::touch::TouchApplication>(scene_), true);
  const auto before = felt_with(std::make_unique<TouchInTheStep>(scene_), true);
  double strongest = 0.0, sum = 0.0, square = 0.0;
  for (std::size_t i = 0; i + 1 < now.size(); ++i) {
    strongest = std::max(strongest, now[i].requested.norm());
    square += (now[i].requested - before[i + 1].requested).squaredNorm();
    sum += now[i].requested.squaredNorm();
  }
  EXPECT_GT(strongest, 1.0);
  EXPECT_LT(std::sqrt(square / sum), 1e-3);
}

}  // namespace
}  // namespace palpate
