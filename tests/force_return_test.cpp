// How a force comes back after something stood still, on the whole chain: simulated arm and hand, the organ
// of `touch` in each of its materials, physics server. In lock-step, and once on the real program with
// SIGSTOP. The rule is that of palpate/device/force_strength.h.
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <thread>

#include "applications/touch/specification.h"
#include "applications/touch/touch.h"
#include "drivers/laboratory/channel.h"
#include "drivers/laboratory/memory.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/config/world_scene.h"
#include "palpate/sim/simulator.h"
#include "palpate/sim/truth_rig.h"
#include "tests/scratch_folder.h"

namespace palpate {
namespace {

struct Material {
  const char* name;
  double stiffness, damping, static_friction, friction;
};
constexpr std::array<Material, 3> kMaterials{{{"plain", 600.0, 2.0, 0.4, 0.3},
                                              {"bone", 800.0, 2.0, 0.3, 0.2},
                                              {"soft-tissue", 110.0, 1.0, 0.2, 0.15}}};

enum class Motion { still, sinking, sliding };
enum class Stopped { server, laboratory };

scene::SceneDescription organ_of(const sim::config::WorldFile& world, const rig::Rig& rig) {
  auto settings = *sim::config::scene_of(world, {applications::touch::specification()}, "touch");
  static const auto coarse =
      std::make_shared<scene::TriangleMesh>(applications::touch::organ_mesh(60));  // made once, and quickly
  settings.mesh = scene::MeshAsset{.mesh = coarse};
  return server::physics::scene_from_rig(rig, settings);
}

// A place 20 mm over the organ's highest.
Vector3 above(const scene::SceneDescription& scene) {
  const applications::touch::TouchApplication application(scene);
  Vector3 top = application.rest().translation;
  for (const auto& vertex : application.surface().vertices) {
    const Vector3 place = (application.rest() * Point<applications::touch::Organ>{vertex}).m;
    if (place.y() > top.y()) top = place;
  }
  return top + 0.02 * Vector3::UnitY();
}

class ListeningArm : public device::ArmDevice {
 public:
  explicit ListeningArm(device::ArmDevice& arm) : arm_(arm) {}
  device::ArmSample read() override { return arm_.read(); }
  void command(const Vector3& force) override {
    newest = force.norm();
    arm_.command(force);
  }
  void let_go() noexcept override { arm_.let_go(); }
  double newest = 0.0;

 private:
  device::ArmDevice& arm_;
};

class PressedOrgan {
 public:
  explicit PressedOrgan(const Material& material)
      : world_(laboratory(material), 1),
        rig_(sim::truth_rig(world_)),
        scene_(organ_of(world_.file(), rig_)),
        arm_(world_.arm()),
        server_(rig_, scene_,
                std::move(*scene::ApplicationRegistry{applications::touch::specification()}.make_physics(
                    scene_, {})),
                arm_, {.permit = haptics::ForcePermit::of_simulated_arm()}) {
    world_.begin_play();
    target_.tip.m = above(scene_);
    run(1500);
    // Down until the organ is met, and on until the hand is pushed back by about a newton.
    for (int ms = 0; ms < 4000 && arm_.newest < 0.9; ++ms) {
      target_.velocity = {0.0, -0.03, 0.0};
      run(1);
    }
    target_.velocity.setZero();
    run(500);
  }
  // The hand goes on as before; who is `stopped` does not.
  void stand_still(Stopped stopped, int ms) {
    for (int i = 0; i < ms; ++i) {
      now_ += std::chrono::milliseconds(1);
      guide();
      if (stopped == Stopped::server) world_.advance_to({now_});
      if (stopped == Stopped::laboratory) tick();
    }
  }
  void run(int ms) {
    for (int i = 0; i < ms; ++i) {
      now_ += std::chrono::milliseconds(1);
      guide();
      world_.advance_to({now_});
      tick();
    }
  }
  void move(Motion motion) {
    if (motion == Motion::sinking) target_.velocity = {0.0, -0.03, 0.0};
    if (motion == Motion::sliding) target_.velocity = {0.05, 0.0, 0.0};
  }
  double commanded() const { return arm_.newest; }
  double asked() { return Vector3(server_.newest().continuous.force.data()).norm(); }
  haptics::HapticCondition condition() const { return server_.haptic().condition(); }

 private:
  static sim::config::WorldFile laboratory(const Material& material) {
    auto file = sim::config::reference_world({applications::touch::specification()});
    file.settings.set("touch.stiffness_n_m", material.stiffness);
    file.settings.set("touch.damping_n_s_m", material.damping);
    file.settings.set("touch.static_friction", material.static_friction);
    file.settings.set("touch.friction", material.friction);
    return file;
  }
  void guide() {
    target_.tip.m += 1e-3 * target_.velocity;
    world_.hand().move_to(target_);
  }
  void tick() {
    server_.haptic_tick({now_});
    server_.physics_tick({now_});
  }

  sim::Simulator world_;
  rig::Rig rig_;
  scene::SceneDescription scene_;
  ListeningArm arm_;
  server::physics::PhysicsServer server_;
  device::HandTarget target_;
  Duration now_{0};
};

class ForceReturn : public testing::TestWithParam<Material> {};

TEST_P(ForceReturn, ByTheRuleAfterEveryStall) {
  for (const Motion motion : {Motion::still, Motion::sinking, Motion::sliding})
    for (const Stopped stopped : {Stopped::server, Stopped::laboratory})
      for (const int ms : {5, 6, 12, 19, 30, 48, 80, 300, 1000, 2000}) {
        SCOPED_TRACE(testing::Message() << "motion " << static_cast<int>(motion) << ", "
                                        << (stopped == Stopped::server ? "server" : "laboratory")
                                        << " still for " << ms << " ms");
        if (ms == 5 && stopped == Stopped::laboratory) continue;  // the next reading comes just in time
        PressedOrgan organ(GetParam());
        const double held = organ.commanded();
        ASSERT_GT(held, 0.6);
        ASSERT_LT(held, 1.4);
        organ.move(motion);
        organ.stand_still(stopped, ms - 1);
        const bool brief = ms <= 50;
        double most_early = 0.0, most_asked = 0.0;
        for (int after = 0; after < 1100; ++after) {
          most_asked = std::max(most_asked, organ.asked());  // of the step before, which the loop answers to
          organ.run(1);
          const double force = organ.commanded();
          ASSERT_NE(organ.condition().fault, device::ForceFault::overspeed) << after;
          ASSERT_NE(organ.condition().state, device::ForceState::safe) << after;
          if (after == 0 && ms > 21) {
            ASSERT_EQ(force, 0.0);
          }
          if (brief && after < 50) most_early = std::max(most_early, force);
          if (brief && after == 49) {
            EXPECT_GE(force, 0.9 * std::min(held, organ.asked()));
          }
          if (!brief) {
            ASSERT_LE(force, 1.05 * std::max(most_asked, organ.asked()) * 1e-3 * after + 1e-9) << after;
          }
        }
        if (brief) {
          EXPECT_LE(most_early, std::max(1.05 * held, held + 0.05));
        }
      }
}

// The laboratory and the physics server as processes; the test is the hand, and reads what the arm is told.
class RealProgram {
 public:
  RealProgram() {
    setenv("XDG_RUNTIME_DIR", scratch_.path().c_str(), 1);
    const sim::Simulator same(sim::config::reference_world(), 1);
    const rig::Rig rig = sim::truth_rig(same);
    if (!rig::write_rig(scratch_.path() / "rig.toml", rig)) throw std::runtime_error("no rig file");
    laboratory_ = start({"world", "run", "--seed", "1"});
    until(
        [&] { return (client_ = drivers::laboratory::LabClient::open("lab").value_or(nullptr)) != nullptr; });
    physics_ = start({"physics", "--app", "touch", "--rig", (scratch_.path() / "rig.toml").string()});
    until([&] { return commands() > 1000; });
    hand_ = std::move(*drivers::laboratory::LabHand::open(client_));
    target_.tip.m = above(organ_of(same.file(), rig));
    top_ = target_.tip.m.y() - 0.02;
  }
  // How far below the organ's highest the hand is led: the tip is no deeper.
  double depth() const { return top_ - target_.tip.m.y(); }
  ~RealProgram() {
    for (const pid_t child : {physics_, laboratory_}) {
      kill(child, SIGCONT);
      kill(child, SIGTERM);
      waitpid(child, nullptr, 0);
    }
  }
  void press() {
    wait(1.5, 0.0);
    for (int i = 0; i < 200 && commanded() < 0.9; ++i) wait(0.02, -0.03);
    wait(1.5, 0.0);
    // A busy machine may have just taken the force away for a moment.
    for (int i = 0; i < 1000 && commanded() <= 0.3; ++i) wait(0.02, 0.0);
  }
  // For so long, with the hand moving up at this speed; what is called each millisecond.
  void wait(double time_s, double speed, const std::function<void()>& each = {}) {
    const auto begun = std::chrono::steady_clock::now();
    double before = 0.0;
    while (true) {
      const double at = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
      target_.tip.m.y() += speed * (at - before);
      before = at;
      hand_->move_to(target_);
      if (each) each();
      if (at >= time_s) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  double commanded() const {
    drivers::laboratory::ForceWire wire;
    client_->memory()->force.read(wire);
    return Vector3(wire.force.data()).norm();
  }
  std::uint64_t commands() const { return client_->memory()->force.count(); }
  void signal(int number) const { kill(physics_, number); }
  bool physics_runs() const { return waitpid(physics_, nullptr, WNOHANG) == 0; }

 private:
  static pid_t start(const std::vector<std::string>& arguments) {
    std::vector<std::string> words{PALPATE_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (auto& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    pid_t child = -1;
    if (posix_spawn(&child, PALPATE_PROGRAM, nullptr, nullptr, pointers.data(), environ) != 0)
      throw std::runtime_error("the program does not start");
    return child;
  }
  static void until(const std::function<bool()>& true_at_last) {
    for (int i = 0; i < 6000; ++i) {
      if (true_at_last()) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    throw std::runtime_error("a minute has passed in vain");
  }

  ScratchFolder scratch_;
  pid_t laboratory_ = -1, physics_ = -1;
  std::shared_ptr<drivers::laboratory::LabClient> client_;
  std::unique_ptr<drivers::laboratory::LabHand> hand_;
  device::HandTarget target_;
  double top_ = 0.0;
};

// Upper bounds alone: on a busy machine forces are off for other reasons, too.
TEST(ForceReturnOfTheProgram, AfterItWasStoppedWithTheHandSinkingIn) {
  RealProgram program;
  program.press();
  const double held = program.commanded();
  ASSERT_GT(held, 0.3);
  program.signal(SIGSTOP);
  program.wait(1.5, -0.01);
  const auto woken = std::chrono::steady_clock::now();
  const auto since = [woken] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - woken).count();
  };
  const auto before = program.commands();
  program.signal(SIGCONT);
  // N. How deep the hand has got by now depends on how busy the machine was.
  const double by_depth = kMaterials[0].stiffness * program.depth();
  double most = 0.0, late = 0.0;
  program.wait(1.0, 0.0, [&] {
    // The last command from before the stop still stands until the first one after it.
    if (program.commands() == before) return;
    // This thread may be held up between any two lines: what counts is when the force may have been read.
    const double from = since(), force = program.commanded(), to = since();
    if (from > 0.05) most = std::max(most, force - by_depth * to);
    if (from > 0.02 && from < 0.1) late = std::max(late, force - by_depth * std::max(0.0, to - 0.1));
  });
  EXPECT_LE(most, 0.05) << 1e3 * program.depth() << " mm";
  EXPECT_LE(late, 0.1 * by_depth + 0.05);
  RecordProperty("depth_um", static_cast<int>(1e6 * program.depth()));
  EXPECT_NE(program.commands(), before);
  EXPECT_TRUE(program.physics_runs());
}

INSTANTIATE_TEST_SUITE_P(Materials, ForceReturn, testing::ValuesIn(kMaterials), [](const auto& made) {
  std::string name = made.param.name;
  std::erase(name, '-');
  return name;
});

}  // namespace
}  // namespace palpate
