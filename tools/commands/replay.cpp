// palpate replay: a recorded session shown again, or executed again and compared.
#include <fmt/format.h>

#include <memory>

#include "palpate/core/child_report.h"
#include "palpate/core/json.h"
#include "palpate/core/text.h"
#include "palpate/server/physics/recording_show.h"
#include "palpate/server/physics/reexecution.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"

namespace palpate::tools::commands {
namespace {

struct ReplayArguments {
  std::string json, listen;
  std::filesystem::path keys, mesh;
  bool verify = false, insecure = false;
  server::physics::ShowOptions show;
};

// 0 where every force is as it was; 1 where one differs, with the first of them in words.
Expected<void> verify(const ReplayArguments& options) {
  const auto result = server::physics::execute_again(
      {.recording = options.show.recording, .applications = known_applications(), .mesh = options.mesh});
  if (!result) return tl::unexpected(result.error());
  if (!options.json.empty())
    if (auto written = write_json(options.json, server::physics::json_of(*result)); !written) return written;
  const std::string file = one_line(options.show.recording.string());
  if (!result->same())
    return refused(
        "{}: executed again it differs: {}; {} of {} ticks have another force, the largest difference is "
        "{:.3g} N",
        file, result->first_difference.empty() ? "it ends early" : result->first_difference,
        result->different_forces, result->recorded_ticks, result->largest_force_difference_n);
  std::string rest = result->lost;
  if (rest.empty() && result->ticks_beyond + result->steps_beyond > 0)
    rest = fmt::format("it breaks off, and its last {} and {} took over what is not in it",
                       counted(result->ticks_beyond, "tick"), counted(result->steps_beyond, "step"));
  if (options.json != "-")
    print_line(fmt::format("{}: executed again: {} ticks and {} steps, every force equal to the last bit{}",
                           file, result->ticks, result->steps,
                           rest.empty() ? "" : "; of the rest nothing is known: " + rest));
  return {};
}

Expected<void> show(ReplayArguments& options) {
  if (options.show.to_s <= options.show.from_s)
    return wrong_use("--to {}: more than --from {} is expected", options.show.to_s, options.show.from_s);
  auto place = server::physics::serving_place(options.listen, options.insecure, options.keys);
  if (!place) return tl::unexpected(place.error());
  options.show.place = std::move(*place);
  server::physics::tell_who_is_admitted(options.show.place, Log("replay"));
  options.show.ready = tell_parent_ready;
  const auto figures = server::physics::show_recording(options.show);
  if (!figures) return tl::unexpected(figures.error());
  if (!options.json.empty()) return write_json(options.json, *figures);
  fmt::print("{:.1f} s shown, {} states, {} of them asked for\n", (*figures)["seconds"].get<double>(),
             (*figures)["states"].get<std::uint64_t>(), (*figures)["requests"].get<std::uint64_t>());
  return {};
}

}  // namespace

void add_replay(CLI::App& program) {
  auto options = std::make_shared<ReplayArguments>();
  auto* command = program.add_subcommand("replay",
                                         "A recorded session shown again to graphics servers and observers, "
                                         "or executed again and compared (--verify)");
  command->add_option("file", options->show.recording, "Recording of a physics server (MCAP)")
      ->required()
      ->type_name("FILE");
  command->add_flag(
      "--verify", options->verify,
      "Execute it again: what the arm read goes into the same loops, and the forces are compared bit by bit");
  command->add_option("--mesh", options->mesh,
                      "The scene's mesh file, where it lies elsewhere than it did (--verify)");
  command->add_option("--from", options->show.from_s, "Begin so many seconds into it")
      ->check(at_least_zero());
  command->add_option("--to", options->show.to_s, "End so many seconds into it")->check(above_zero());
  command->add_option("--speed", options->show.speed, "So many times as fast")
      ->check(between(0.01, 100.0))
      ->capture_default_str();
  command->add_flag("--loop", options->show.loop, "Again and again, until Ctrl-C");
  command->add_option("--listen", options->listen,
                      "ZeroMQ address; the default is a socket private to this user (ipc://...)");
  command->add_option("--keys", options->keys, "Folder of keys for tcp://; see palpate keys");
  command->add_flag("--insecure", options->insecure, "Serve tcp:// without keys: anyone who reaches it sees");
  command->add_option("--json", options->json, "Write the figures here at the end; - = standard output");
  on(command, [options, command]() -> Expected<void> {
    if (!options->verify) {
      if (auto fine = refuse_given(*command, {"--mesh"}, "goes with --verify"); !fine) return fine;
      return show(*options);
    }
    if (auto fine = refuse_given(*command,
                                 {"--from", "--to", "--speed", "--loop", "--listen", "--keys", "--insecure"},
                                 "goes without --verify, which executes all of it and shows nothing");
        !fine)
      return fine;
    return verify(*options);
  });
}

}  // namespace palpate::tools::commands
