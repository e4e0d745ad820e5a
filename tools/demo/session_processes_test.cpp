// Beside command lines as a person would type them.
#include "tools/demo/session_processes.h"

#include <gtest/gtest.h>

#include <sstream>

namespace palpate::tools::demo {
namespace {

std::vector<std::string> words(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> result;
  for (std::string word; stream >> word;) result.push_back(word);
  return result;
}

TEST(SessionProcesses, ADemosRunInRealTime) {
  SessionProcesses session;
  session.name = "demo-7";
  session.rig = "out/rig.toml";
  session.world = "out/world.toml";
  session.seed = 18446744073709551615u;
  session.out = "out/raw";
  session.laboratory = {.seconds = 70.5, .exposures = "out/raw/realtime_truth.csv"};
  session.physics.application = "touch";
  session.physics.listen.address = "ipc:///run/demo.sock";
  session.graphics.connect = session.physics.listen;
  session.graphics.player = session.graphics.timecode = true;
  session.graphics.quality = render::Quality::low;
  session.graphics.seconds = 10.0;
  session.graphics.clock = {.offset_s = -3.25, .drift = 4e-5};
  EXPECT_EQ(laboratory_arguments(session),
            words("world run --name demo-7 --seconds 70.5 --world out/world.toml --seed "
                  "18446744073709551615 --exposures out/raw/realtime_truth.csv"));
  EXPECT_EQ(physics_arguments(session),
            words("physics --app touch --listen ipc:///run/demo.sock --rig out/rig.toml --lab demo-7 "
                  "--world out/world.toml --seed 18446744073709551615 --out out/raw"));
  EXPECT_EQ(
      graphics_arguments(session),
      words("graphics --quality low --player --seconds 10 --disguise-offset-s -3.250000000 "
            "--disguise-drift-ppm 40.000000 --clock-strip --connect ipc:///run/demo.sock --rig "
            "out/rig.toml --lab demo-7 --world out/world.toml --seed 18446744073709551615 --out out/raw"));
}

TEST(SessionProcesses, APersonAtAWindowAndTwoHostsWithKeysOrWithout) {
  SessionProcesses session;
  session.name = "desk";
  session.rig = "desk.toml";
  session.world = "arm.toml";
  session.laboratory = {.seconds = 100.0, .arm_only = true};
  session.physics = {.application = "pingpong", .pause_s = 0.8, .listen = {}};
  session.physics.listen = {.address = "tcp://192.0.2.1:5555", .insecure = false, .keys = "keys/physics"};
  session.graphics.connect = {.address = "tcp://192.0.2.1:5555", .insecure = true};
  session.graphics.window = true;
  session.graphics.monitor = desktop::MonitorView::outside;
  session.graphics.headset = true;
  EXPECT_EQ(laboratory_arguments(session),
            words("world run --name desk --seconds 100 --world arm.toml --seed 1 --arm-only"));
  EXPECT_EQ(physics_arguments(session),
            words("physics --app pingpong --serve-pause-s 0.8 --listen tcp://192.0.2.1:5555 --keys "
                  "keys/physics --rig desk.toml --lab desk --world arm.toml --seed 1"));
  EXPECT_EQ(graphics_arguments(session),
            words("graphics --quality auto --seconds 0 --disguise-offset-s 0.000000000 "
                  "--disguise-drift-ppm 0.000000 --window --mouse --headset --monitor outside --connect "
                  "tcp://192.0.2.1:5555 --insecure --rig desk.toml --lab desk --world arm.toml --seed 1"));
}

}  // namespace
}  // namespace palpate::tools::demo
