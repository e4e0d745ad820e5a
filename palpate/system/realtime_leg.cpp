#include "palpate/system/realtime_leg.h"

#include <unistd.h>

#include <chrono>
#include <thread>

#include "palpate/devices/lab_channel.h"
#include "palpate/network/local_endpoint.h"
#include "palpate/system/child_process.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

// The last line a process wrote to its log: its error, if it had one.
std::string last_words(const std::filesystem::path& log) {
  auto text = read_file(log);
  if (!text) return "no message";
  while (!text->empty() && text->back() == '\n') text->pop_back();
  const auto line = text->substr(text->rfind('\n') + 1);
  return line.empty() ? "no message" : line;
}

Expected<Json> read_json(const std::filesystem::path& path) {
  auto text = read_file(path);
  if (!text) return tl::unexpected(text.error());
  Json json = Json::parse(*text, nullptr, false);
  if (json.is_discarded()) return refused("{}: is not JSON", path.string());
  return json;
}

}  // namespace

Expected<Json> run_realtime_leg(const RealtimeLegOptions& options,
                                const std::function<void(double)>& progress) {
  const std::string name = fmt::format("demo-{}", ::getpid());
  const auto endpoint = default_endpoint(name);
  if (!endpoint) return tl::unexpected(endpoint.error());
  const auto file = [&](const std::string& part, const std::string& ending) {
    return options.out / ("realtime_" + part + ending);
  };
  const std::string seed = std::to_string(options.seed);
  const auto arguments = [&](std::vector<std::string> list) {
    list.insert(list.end(), {"--world", options.world.string(), "--seed", seed});
    return list;
  };

  // The laboratory outlives the leg's length and is asked to stop at its end. It ends by itself, and the
  // physics server with it, where nobody is left to ask.
  const double patience = options.seconds + 30.0;
  auto world = ChildProcess::start(
      options.program,
      arguments({"world", "run", "--name", name, "--seconds", fmt::format("{}", patience + 30.0)}),
      file("world", ".log"));
  if (!world) return tl::unexpected(world.error());
  for (int i = 0;; ++i) {
    if (progress) progress(0.0);
    if (LabClient::open(name)) break;
    if (!world->running())
      return refused("real-time leg: the laboratory ended (exit {}): {}", *world->wait({}),
                     last_words(file("world", ".log")));
    if (i > 1000) return refused("real-time leg: the laboratory did not open its devices within 10 s");
    std::this_thread::sleep_for(milliseconds(10));
  }
  auto physics =
      ChildProcess::start(options.program,
                          arguments({"physics", "--rig", options.rig.string(), "--lab", name, "--listen",
                                     endpoint->address, "--json", file("physics", ".json").string()}),
                          file("physics", ".log"));
  if (!physics) return tl::unexpected(physics.error());
  auto graphics = ChildProcess::start(
      options.program,
      arguments({"graphics", "--rig", options.rig.string(), "--lab", name, "--connect", endpoint->address,
                 "--player", "--seconds", fmt::format("{}", options.seconds), "--disguise-offset-s",
                 fmt::format("{:.9f}", options.graphics_clock.offset_s), "--disguise-drift-ppm",
                 fmt::format("{:.6f}", options.graphics_clock.drift * 1e6), "--out", options.out.string(),
                 "--json", file("graphics", ".json").string()}),
      file("graphics", ".log"));
  if (!graphics) return tl::unexpected(graphics.error());

  const auto begun = std::chrono::steady_clock::now();
  while (true) {
    const auto code = graphics->wait(milliseconds(100));
    const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
    if (progress) progress(elapsed / (options.seconds + 1.0));
    if (code && *code != 0)
      return refused("real-time leg: the graphics server ended (exit {}): {}", *code,
                     last_words(file("graphics", ".log")));
    if (code) break;
    if (!physics->running())
      return refused("real-time leg: the physics server ended (exit {}): {}", *physics->wait({}),
                     last_words(file("physics", ".log")));
    if (elapsed > patience)
      return refused("real-time leg: the graphics server did not end within {:.0f} s", patience);
  }
  physics->ask_to_stop();
  const auto code = physics->wait(std::chrono::seconds(5));
  if (!code || *code != 0)
    return refused("real-time leg: the physics server did not end in order: {}",
                   last_words(file("physics", ".log")));
  world->ask_to_stop();
  world->wait(std::chrono::seconds(5));

  auto from_graphics = read_json(file("graphics", ".json"));
  if (!from_graphics) return tl::unexpected(from_graphics.error());
  auto from_physics = read_json(file("physics", ".json"));
  if (!from_physics) return tl::unexpected(from_physics.error());
  Json result = *from_graphics;
  result["haptic"] = (*from_physics)["haptic"];
  result["physics"] = (*from_physics)["physics"];
  result["force"] = (*from_physics)["force"];
  for (const std::string part : {"world", "physics", "graphics"}) {
    std::error_code ignored;
    std::filesystem::remove(file(part, ".log"), ignored);
    std::filesystem::remove(file(part, ".json"), ignored);
  }
  return result;
}

}  // namespace palpate
