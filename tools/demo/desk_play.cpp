#include "tools/demo/desk_play.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "palpate/core/child_process.h"
#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "palpate/core/run_directory.h"
#include "palpate/core/stop_signal.h"
#include "palpate/transport/local_endpoint.h"
#include "tools/demo/joint_recording.h"
#include "tools/demo/session_processes.h"

namespace palpate::tools::demo {
namespace {

using std::chrono::milliseconds;

constexpr double kLongestGame_s = 4.0 * 3600.0;  // then the arm ends, should nobody be left to stop it
constexpr double kPauseAtDesk_s = 0.8;           // between two rounds, for people

// Angles about x, y, z, applied in this order.
Vector3 angles_of(const Quaternion& rotation) {
  const Matrix3 R = rotation.toRotationMatrix();
  return {std::atan2(R(2, 1), R(2, 2)), -std::asin(std::clamp(R(2, 0), -1.0, 1.0)),
          std::atan2(R(1, 0), R(0, 0))};
}

sim::config::Corners corners_of(const rig::SurfaceCalibration& surface) {
  return {surface.corner(0).m, surface.corner(1).m, surface.corner(2).m, surface.corner(3).m};
}

// Files of one game, gone with it.
class GameFiles {
 public:
  GameFiles(std::filesystem::path folder, std::string name)
      : folder_(std::move(folder)), name_(std::move(name)) {}
  GameFiles(const GameFiles&) = delete;
  GameFiles& operator=(const GameFiles&) = delete;
  ~GameFiles() {
    std::error_code ignored;
    for (const char* what : {".world.toml", ".world.log", ".physics.log"})
      std::filesystem::remove(file(what), ignored);
  }
  std::filesystem::path file(const std::string& what) const { return folder_ / (name_ + what); }

 private:
  std::filesystem::path folder_;
  std::string name_;
};

Expected<void> wait_for_arm(ChildProcess& world) {
  for (int i = 0; !world.reports().ready(); ++i) {
    if (!world.running())
      return refused("play: the arm ended (exit {}): {}", *world.wait({}), world.why_it_ended());
    if (i > 1000) return refused("play: the arm did not begin within 10 s; look whether the machine is busy");
    std::this_thread::sleep_for(milliseconds(10));
  }
  return {};
}

// An application may have to get ready first, for half a minute and more.
Expected<void> wait_for_physics(ChildProcess& physics) {
  constexpr int kSoon = 150;  // looks
  for (int i = 0; !physics.reports().ready(); ++i) {
    if (!physics.running())
      return refused("play: the physics server ended (exit {}): {}", *physics.wait({}),
                     physics.why_it_ended());
    if (stop_requested()) return refused("play: stopped before the physics server was ready");
    if (i == kSoon) Log("play").info("the application is getting ready; the window opens when it is");
    std::this_thread::sleep_for(milliseconds(10));
  }
  return {};
}

}  // namespace

sim::config::WorldFile desk_world(const rig::Rig& rig) {
  sim::config::WorldFile world = sim::config::reference_world();
  auto& arm = world.arm;
  arm.lengths = {rig.arm->model.lengths.l1, rig.arm->model.lengths.l2};
  arm.length_sd = arm.gain_sd = arm.offset_sd = arm.gimbal_gain_sd = arm.gimbal_offset_sd = 0.0;
  arm.hysteresis = 0.0;
  arm.translation = rig.arm->X_world_base.translation;
  arm.rotation = angles_of(rig.arm->X_world_base.rotation);
  world.tip_marker.mount_sd = 0.0;
  if (const auto* table = rig.surface("table")) world.scene.table = corners_of(*table);
  if (const auto* wall = rig.surface("wall")) world.scene.wall = corners_of(*wall);
  return world;
}

Expected<Json> play_at_desk(const DeskPlayOptions& options) {
  const std::string name = fmt::format("desk-{}", ::getpid());
  const auto folder = run_directory();
  if (!folder) return tl::unexpected(folder.error());
  const auto endpoint = transport::default_endpoint(name);
  if (!endpoint) return tl::unexpected(endpoint.error());
  const GameFiles files(*folder, name);
  server::session::GraphicsProcessOptions graphics = options.graphics;
  graphics.world = desk_world(graphics.rig);
  graphics.world.settings = options.settings;
  SessionProcesses session;
  session.name = name;
  session.rig = options.rig_file;
  session.world = files.file(".world.toml");
  session.seed = options.seed;
  session.laboratory = {.seconds = kLongestGame_s, .exposures = {}, .arm_only = true};
  session.physics.application = options.application;
  session.physics.pause_s = kPauseAtDesk_s;
  session.physics.listen.address = endpoint->address;
  const JointRecording recording(graphics.record);
  if (auto fine = recording.check(); !fine) return tl::unexpected(fine.error());
  session.physics.record = recording.physics();
  graphics.record = recording.graphics();
  if (auto done = write_file(session.world, sim::config::world_text(graphics.world)); !done)
    return tl::unexpected(done.error());

  auto world = ChildProcess::start(options.program, laboratory_arguments(session), files.file(".world.log"));
  if (!world) return tl::unexpected(world.error());
  if (auto there = wait_for_arm(*world); !there) return tl::unexpected(there.error());
  auto physics = ChildProcess::start(options.program, physics_arguments(session), files.file(".physics.log"));
  if (!physics) return tl::unexpected(physics.error());
  if (auto there = wait_for_physics(*physics); !there) return tl::unexpected(there.error());

  graphics.stand_in = "lab:" + name;
  graphics.server.address = endpoint->address;
  auto figures = server::session::run_graphics_process(graphics);
  if (!physics->running())
    return refused("play: the physics server ended (exit {}): {}", *physics->wait({}),
                   physics->why_it_ended());
  physics->ask_to_stop();
  physics->wait(std::chrono::seconds(30));  // an application may be preparing what comes next
  world->ask_to_stop();
  world->wait(std::chrono::seconds(5));
  if (figures)
    if (auto joined = recording.join(); !joined) return tl::unexpected(joined.error());
  return figures;
}

}  // namespace palpate::tools::demo
