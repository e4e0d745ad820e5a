// palpate console: a running session in a browser, and for common viewers.
#include <memory>

#include "drivers/network/address.h"
#include "palpate/core/child_report.h"
#include "palpate/core/json.h"
#include "palpate/core/text.h"
#include "palpate/web/web_guard.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/server_options.h"
#include "tools/console/console.h"

namespace palpate::tools::commands {
namespace {

constexpr drivers::network::Protocol kWeb{"HTTP", "a web server", "http://", 8765};

struct ConsoleArguments {
  console::ConsoleOptions console;
  std::string listen = "127.0.0.1:8765", json;
  bool exposed = false;
  CLI::Option* pictures = nullptr;
};

Expected<void> show_console(ConsoleArguments& options) {
  const auto place = drivers::network::parse_listen(options.listen, kWeb, options.exposed, "--exposed");
  if (!place) return wrong_use("--listen: {}", place.error().message);
  auto& console = options.console;
  console.address = place->host;
  console.port = place->port;
  if (options.pictures->count() == 0) console.pictures = web::is_loopback(place->host);
  console.ready = tell_parent_ready;
  const auto figures = console::run_console(console);
  if (!figures) return tl::unexpected(figures.error());
  tell_parent_result(*figures);
  if (!options.json.empty()) return write_json(options.json, *figures);
  return {};
}

}  // namespace

void add_console(CLI::App& program) {
  auto options = std::make_shared<ConsoleArguments>();
  auto* command = program.add_subcommand(
      "console",
      "A running session in a browser: lights, forces, tip and bodies, clocks, trips; and for Lichtblick "
      "and Foxglove on the same port");
  add_server_options(*command, options->console.server);
  command
      ->add_option("--listen", options->listen,
                   "Where the page is: PORT or HOST:PORT; port 0 = any that is free")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  command->add_flag(
      "--exposed", options->exposed,
      "Let --listen be reached from other machines: by whoever has the token; nothing is encrypted");
  command->add_flag("--controls", options->console.controls,
                    "Let whoever has the token reset, pause and resume");
  command->add_flag("--private", options->console.look_with_token,
                    "Show nothing without the token, to other users of this machine either");
  options->pictures = command->add_flag(
      "--pictures,!--no-pictures", options->console.pictures,
      "Show what the graphics server of this machine shows; on, but not with --exposed, for "
      "pictures show people");
  command
      ->add_option("--allow-origin", options->console.origins,
                   "A page of another host that may look, as https://app.foxglove.dev; several: again")
      ->type_name("URL");
  command
      ->add_option("--allow-host", options->console.hosts,
                   "Another name of this machine by which it may be asked; several: again")
      ->type_name("NAME");
  command->add_option("--seconds", options->console.seconds, "Stop after this many seconds; 0 = at Ctrl-C")
      ->check(at_least_zero())
      ->default_val(0.0);
  command->add_option("--json", options->json, "Write the figures here at the end; - = standard output");
  on(command, [options] { return show_console(*options); });
}

}  // namespace palpate::tools::commands
