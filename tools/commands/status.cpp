#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>
#include <thread>

#include "palpate/core/json.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/transport/messages.h"
#include "palpate/transport/status_json.h"
#include "palpate/transport/zmq_engine.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/server_options.h"

namespace palpate::tools::commands {
namespace {

constexpr double kAnswerWithin = 5.0;      // s
constexpr double kSocketMadeWithin = 1.0;  // s; a server that is only just starting makes it meanwhile

// Whether a server of this machine can answer there at all: it makes a socket in the file system.
bool has_socket(const std::string& address) {
  constexpr std::string_view kLocal = "ipc://";
  std::error_code failed;
  return !address.starts_with(kLocal) || address.starts_with("ipc://@") ||
         std::filesystem::exists(address.substr(kLocal.size()), failed);
}

struct StatusArguments {
  transport::ServerName server;
  std::string json;
  bool once = false, reset = false;
  std::optional<double> interval_s;  // a view after the other, wherever they go
};

std::string duration_text(double us) {
  if (us < 1000.0) return fmt::format("{:.1f} us", us);
  if (us < 1e6) return fmt::format("{:.1f} ms", 1e-3 * us);
  return fmt::format("{:.1f} s", 1e-6 * us);
}

// Lateness by octave, all below a microsecond in one; each bar on a logarithmic scale so that one tick in a
// million still shows.
std::vector<std::string> histogram(const transport::LoopStatus& loop) {
  constexpr int kWidth = 40;
  constexpr std::size_t kMicrosecond = 6;  // 16 ns * 2^6
  std::vector<std::uint64_t> counts(std::max(loop.late_octaves.size(), kMicrosecond + 1), 0);
  for (std::size_t i = 0; i < loop.late_octaves.size(); ++i)
    counts[std::max(i, kMicrosecond)] += loop.late_octaves[i];
  while (!counts.empty() && counts.back() == 0) counts.pop_back();
  std::vector<std::string> lines;
  if (counts.empty()) return lines;
  const double most = static_cast<double>(*std::max_element(counts.begin(), counts.end()));
  bool begun = false;
  for (std::size_t i = kMicrosecond; i < counts.size(); ++i) {
    begun = begun || counts[i] > 0;
    if (!begun) continue;
    const double share = std::log1p(static_cast<double>(counts[i])) / std::log1p(most);
    const std::string bar(static_cast<std::size_t>(std::ceil(kWidth * share)), '#');
    lines.push_back(fmt::format("    under {:>9}  {:<{}} {}",
                                duration_text(0.016 * std::exp2(static_cast<double>(i))), bar, kWidth,
                                counts[i]));
  }
  return lines;
}

std::string status_text(const transport::ServerStatus& status, const std::string& address) {
  std::vector<std::string> lines{fmt::format("{} at {}, up {:.0f} s", excerpt(status.application, 64),
                                             one_line(address), status.uptime_s)};
  for (const auto& loop : status.loops) {
    lines.push_back(fmt::format("\n{} loop  {:.1f} Hz, {} ticks, {} overruns, {} missed",
                                excerpt(loop.name, 64), loop.rate_hz, loop.ticks, loop.overruns,
                                loop.missed));
    lines.push_back(fmt::format("  late  median {}, p99 {}, max {}; at work p99 {} (bars: logarithmic)",
                                duration_text(loop.late_p50_us), duration_text(loop.late_p99_us),
                                duration_text(loop.late_max_us), duration_text(loop.busy_p99_us)));
    if (loop.forces && !status.failure.empty())
      lines.push_back(fmt::format("  forces off: {}", excerpt(status.failure, transport::kMaxReasonBytes)));
    else if (loop.forces)
      lines.push_back(fmt::format("  forces {}", excerpt(loop.forces_text(), 150)));
    if (loop.peak_n > 0.0)
      lines.push_back(fmt::format("  limits {:.1f} N, {:.1f} N for long; {} so far", loop.peak_n,
                                  loop.continuous_n, counted(loop.trips, "outage")));
    for (auto& bar : histogram(loop)) lines.push_back(std::move(bar));
  }
  lines.push_back(fmt::format("\n{}", counted(status.clients.size(), "client")));
  for (const auto& client : status.clients) {
    const auto& f = client.figures;
    std::string line =
        fmt::format("  {:<12} {:<9}", excerpt(client.name, 12), transport::role_name(client.role));
    if (f.frames > 0)
      line += fmt::format(
          " {:.1f} Hz, {} of {} frames late, {} lost; round trip {} (p99 {}); clock {:+.6f} s +- {}",
          f.rate_hz, f.late, f.frames, f.lost, duration_text(f.round_trip_median_us),
          duration_text(f.round_trip_p99_us), f.clock_offset_s, duration_text(f.clock_uncertainty_us));
    lines.push_back(line);
    for (const auto& condition : f.conditions)
      lines.push_back(fmt::format("    ! {}", excerpt(condition.words, transport::kMaxConditionBytes)));
  }
  lines.push_back(fmt::format("\n{} states answered, {} published, {} clock exchanges, {} controls",
                              status.requests, status.published, status.syncs, status.controls));
  if (const auto& r = status.recording)
    lines.push_back(fmt::format("recording {:.0f} s, {} dropped{}", r->seconds,
                                counted(r->dropped, "message"),
                                r->ended ? ": ended by an error of the disk" : ""));
  lines.push_back(fmt::format("{} messages refused, {} connections turned away, {} answers not taken",
                              status.rejected, status.rejected_connections, status.unsent));
  std::string text;
  for (const auto& line : lines) text += line + '\n';
  return text;
}

Expected<void> show_status(const StatusArguments& options) {
  const auto& stop = stop_requested();
  const auto place = transport::server_place(options.server);
  if (!place) return tl::unexpected(place.error());
  const transport::Endpoint& endpoint = place->endpoint;
  const MonotonicClock<GraphicsClock> clock;
  auto link = transport::connect_states(endpoint, clock, "status", place->identity);
  if (!link) return tl::unexpected(link.error());

  constexpr double kInterval = 0.2;  // s
  const bool terminal = isatty(STDOUT_FILENO) != 0;
  // Into a pipe or a file goes one view, unless an interval is asked for: who waits for the end would wait for ever.
  const bool live =
      !options.once && !options.reset && options.json.empty() && (terminal || options.interval_s);
  const auto begun = clock.now();
  auto heard = begun, told = begun;  // anything, and a status
  std::optional<Instant<GraphicsClock>> asked;
  std::uint64_t statuses = 0;  // that have come
  const transport::ServerStatus* shown = nullptr;
  transport::ServerStatus last;
  std::optional<std::uint64_t> controls_before;  // how many the server had taken when --reset was sent
  while (!stop.load()) {
    (*link)->poll();
    const auto now = clock.now();
    if ((*link)->peer_alive()) heard = now;
    const bool in_vain = now - begun > seconds(kSocketMadeWithin) && !has_socket(endpoint.address);
    if (in_vain || now - heard > seconds(kAnswerWithin)) {
      const auto trouble = (*link)->trouble();
      if (trouble)
        return refused("status: the physics server at {} turns us away: {}", endpoint.address, *trouble);
      return refused(
          "status: no physics server answers at {}; start `palpate physics` first (one that still prepares "
          "what it plays answers when it is ready)",
          endpoint.address);
    }
    if (options.reset && now - begun > seconds(kAnswerWithin))
      return refused("status: --reset: the physics server at {0} has not {2} within {1} s{3}",
                     endpoint.address, kAnswerWithin, (*link)->role() ? "taken the wish" : "said",
                     (*link)->role() ? "" : " what this machine's key may do");
    if ((*link)->statuses() != statuses) statuses = (*link)->statuses(), told = now;
    if (now - told > seconds(kAnswerWithin)) {
      const auto refusal = (*link)->refusal();
      return refused(
          "status: the physics server at {} answers, but has not said for {} s how it is doing{}{}",
          endpoint.address, kAnswerWithin, refusal ? "; it refuses: " : "",
          refusal ? excerpt(*refusal, 200) : "");
    }
    if ((!asked || now - *asked >= seconds(options.interval_s.value_or(kInterval))) && (*link)->ask_status())
      asked = now;
    const bool may_say =
        !options.reset || (*link)->role();  // what we may do comes with the answer to our hello
    if (may_say && (*link)->status() && (shown == nullptr || (*link)->status()->uptime_s != last.uptime_s)) {
      last = *(*link)->status();
      shown = &last;
      if (options.reset && !controls_before) {
        if ((*link)->role() != transport::Role::operator_)
          return refused(
              "status: --reset: this machine's key has not the role operator at {}; there, `palpate keys "
              "authorize` gives it",
              endpoint.address);
        controls_before = last.controls;
        (*link)->send_control(scene::Control::reset);
      }
      if (controls_before && last.controls == *controls_before) continue;  // not taken yet
      if (!options.json.empty()) return write_json(options.json, transport::status_json(last));
      // On a terminal each view takes the place of the one before.
      fmt::print("{}{}", live && terminal ? "\x1b[H\x1b[2J" : "", status_text(last, endpoint.address));
      if (live && !terminal) fmt::print("\n");
      std::fflush(stdout);
      if (!live) return {};
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return {};
}

}  // namespace

void add_status(CLI::App& program) {
  auto* command = program.add_subcommand(
      "status", "How a running system is doing: loops, clients, exchange; live on a terminal");
  auto options = std::make_shared<StatusArguments>();
  add_server_options(*command, options->server);
  command->add_flag("--once", options->once,
                    "Print one view and end, as into a pipe or file without --interval-s");
  command->add_flag("--reset", options->reset,
                    "As an operator: forces that were switched off for good come back, ramped, where their "
                    "reason has gone; the application's counters begin anew. Print one view and end");
  command
      ->add_option("--interval-s", options->interval_s,
                   "Time between two views, wherever they go (on a terminal: 0.2)")
      ->check(between(0.1, 60.0));
  command->add_option("--json", options->json, "Write one view as JSON to FILE (- = standard output) and end")
      ->type_name("FILE");
  on(command, [options] { return show_status(*options); });
}

}  // namespace palpate::tools::commands
