#include "tools/demo/session_processes.h"

#include <fmt/format.h>

namespace palpate::tools::demo {
namespace {

// A command line as it grows.
class Arguments {
 public:
  explicit Arguments(std::vector<std::string> command) : words_(std::move(command)) {}
  Arguments& flag(const char* name, bool set) {
    if (set) words_.emplace_back(name);
    return *this;
  }
  Arguments& option(const char* name, std::string value) {
    words_.emplace_back(name);
    words_.push_back(std::move(value));
    return *this;
  }
  Arguments& unless_empty(const char* name, const std::filesystem::path& value) {
    return value.empty() ? *this : option(name, value.string());
  }
  Arguments& server(const char* name, const transport::ServerName& server) {
    if (!server.address.empty()) option(name, server.address);
    return unless_empty("--keys", server.keys).flag("--insecure", server.insecure);
  }
  // What both servers are told alike.
  Arguments& both_servers(const SessionProcesses& session) {
    return option("--rig", session.rig.string())
        .option("--lab", session.name)
        .option("--world", session.world.string())
        .option("--seed", std::to_string(session.seed))
        .unless_empty("--out", session.out);
  }
  std::vector<std::string> words() { return std::move(words_); }

 private:
  std::vector<std::string> words_;
};

}  // namespace

std::vector<std::string> laboratory_arguments(const SessionProcesses& session) {
  return Arguments({"world", "run"})
      .option("--name", session.name)
      .option("--seconds", fmt::format("{}", session.laboratory.seconds))
      .option("--world", session.world.string())
      .option("--seed", std::to_string(session.seed))
      .unless_empty("--exposures", session.laboratory.exposures)
      .flag("--arm-only", session.laboratory.arm_only)
      .words();
}

std::vector<std::string> physics_arguments(const SessionProcesses& session) {
  const PhysicsServerProcess& physics = session.physics;
  Arguments arguments({"physics"});
  arguments.option("--app", physics.application);
  if (physics.pause_s) arguments.option("--serve-pause-s", fmt::format("{}", *physics.pause_s));
  arguments.unless_empty("--record", physics.record);
  return arguments.server("--listen", physics.listen).both_servers(session).words();
}

std::vector<std::string> graphics_arguments(const SessionProcesses& session) {
  const GraphicsServerProcess& graphics = session.graphics;
  Arguments arguments({"graphics"});
  arguments.option("--quality", std::string(render::quality_choice_word(graphics.quality)))
      .flag("--player", graphics.player)
      .option("--seconds", fmt::format("{}", graphics.seconds))
      .option("--disguise-offset-s", fmt::format("{:.9f}", graphics.clock.offset_s))
      .option("--disguise-drift-ppm", fmt::format("{:.6f}", graphics.clock.drift * 1e6))
      .flag("--clock-strip", graphics.timecode)
      .flag("--window", graphics.window)
      .flag("--mouse", graphics.window)
      .flag("--headset", graphics.headset);
  if (graphics.monitor)
    arguments.option("--monitor", std::string(desktop::monitor_view_word(*graphics.monitor)));
  arguments.unless_empty("--record", graphics.record).unless_empty("--pictures", graphics.pictures);
  return arguments.server("--connect", graphics.connect).both_servers(session).words();
}

}  // namespace palpate::tools::demo
