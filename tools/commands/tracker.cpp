#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "drivers/ndi/protocol.h"
#include "drivers/network/recording.h"
#include "drivers/openigtlink/protocol.h"
#include "drivers/vrpn/protocol.h"
#include "palpate/core/json.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/time/clock.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/pose_recorder.h"

namespace palpate::tools::commands {
namespace {

struct ListenArguments {
  std::string address, tool, out, json;
  double seconds = 0.0;
};

struct HeardTool {
  std::uint64_t poses = 0, unseen = 0;
  std::int64_t first_ns = 0, last_ns = 0;  // arrivals

  double rate_hz() const {
    return last_ns > first_ns
               ? 1e9 * static_cast<double>(poses + unseen - 1) / static_cast<double>(last_ns - first_ns)
               : 0.0;
  }
};

double since(std::int64_t start_ns) {
  return 1e-9 * static_cast<double>(MonotonicClock<TrackerClock>::monotonic_ns() - start_ns);
}

void sleep_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

// What is new about the connection, also where it came and went between two looks; and, once, that there is
// none yet.
class LinkNews {
 public:
  void look(const drivers::network::PoseClientState& state, double now_s,
            const std::function<void(const char*)>& tell) {
    if (state.connections == 0 && now_s > kPatience && !std::exchange(waiting_told_, true))
      tell("nobody answers there yet; waiting for a server");
    if (state.connections != connections_) {
      if (connected_) tell(kGone);
      tell("connected");
      connections_ = state.connections;
      connected_ = true;
    }
    if (connected_ && !state.connected) {
      tell(kGone);
      connected_ = false;
    }
  }

 private:
  static constexpr const char* kGone = "the server has gone; waiting for it";
  static constexpr double kPatience = 1.5;
  bool waiting_told_ = false;
  std::uint64_t connections_ = 0;
  bool connected_ = false;
};

// One line that is written over, on a terminal only.
class LiveLine {
 public:
  void show(const std::map<std::string, HeardTool>& tools, double elapsed_s) {
    if (!terminal_ || elapsed_s < next_s_) return;
    next_s_ = elapsed_s + 0.25;
    std::string line;
    for (const auto& [name, tool] : tools)
      line += fmt::format("  {} {} ({:.1f} Hz)", name, tool.poses, tool.rate_hz());
    std::fprintf(stderr, "\r\x1b[K%s", excerpt(line, 160).c_str());
    shown_ = true;
  }
  void end() {
    if (std::exchange(shown_, false)) std::fprintf(stderr, "\r\x1b[K");
  }

 private:
  const bool terminal_ = isatty(STDERR_FILENO) != 0;
  bool shown_ = false;
  double next_s_ = 0.0;
};

std::string names_of(const std::map<std::string, HeardTool>& tools) {
  std::string names;
  for (const auto& [name, tool] : tools) names += (names.empty() ? "" : ", ") + name;
  return excerpt(names, 160);
}

// A protocol that poses come by, and what a server of it has to send.
struct Wire {
  drivers::network::Protocol protocol;
  const char* sends;
};
constexpr Wire kOpenIgtlink{drivers::openigtlink::kProtocol, "TRANSFORM or TDATA"},
    kVrpn{drivers::vrpn::kProtocol, "poses of a tracker"},
    kNdi{drivers::ndi::kProtocol, "poses of its tools"};

// "vrpn://HOST", "ndi://HOST" or "igtl://HOST"; without a scheme OpenIGTLink. Takes the scheme off.
const Wire& wire_of(std::string& address) {
  for (const Wire* wire : {&kVrpn, &kNdi, &kOpenIgtlink})
    if (address.starts_with(wire->protocol.scheme)) {
      address.erase(0, std::string_view(wire->protocol.scheme).size());
      return *wire;
    }
  return kOpenIgtlink;
}

Expected<std::unique_ptr<drivers::network::PoseClient>> connect_to(const Wire& wire,
                                                                   const drivers::network::Address& address,
                                                                   const std::vector<std::string>& files) {
  if (&wire == &kVrpn) return drivers::vrpn::connect(address);
  if (&wire == &kOpenIgtlink) return drivers::openigtlink::connect(address);
  auto definitions = drivers::ndi::read_definitions(files);
  if (!definitions) return tl::unexpected(definitions.error());
  return drivers::ndi::connect(address, {.wireless = std::move(*definitions)});
}

Expected<std::unique_ptr<drivers::network::PoseServer>> listen_at(const Wire& wire,
                                                                  const drivers::network::Address& address,
                                                                  const std::set<std::string>& tools) {
  if (&wire == &kVrpn) return drivers::vrpn::listen(address);
  if (&wire == &kOpenIgtlink) return drivers::openigtlink::listen(address);
  return drivers::ndi::listen(address, {.tools = {tools.begin(), tools.end()}});
}

Expected<void> nothing_heard(const std::string& where, const Wire& wire,
                             const drivers::network::PoseClientState& state) {
  if (state.connections == 0)
    return refused("{}: nobody answers there; {} is expected, start it or check the address", where,
                   wire.protocol.server);
  if (!state.trouble.empty())
    return refused("{}: no pose came: {}; {} that sends {} is expected", where, excerpt(state.trouble, 200),
                   wire.protocol.server, wire.sends);
  return refused("{}: connected, but no pose came; check that the server sends {}", where, wire.sends);
}

Json json_of(const std::map<std::string, HeardTool>& tools, const drivers::network::PoseClientState& state) {
  Json json;
  json["tools"] = Json::array();
  for (const auto& [name, tool] : tools)
    json["tools"].push_back(
        {{"name", name}, {"poses", tool.poses}, {"unseen", tool.unseen}, {"rate_hz", tool.rate_hz()}});
  json["connections"] = state.connections;
  json["lost"] = state.lost;
  json["repeats"] = state.repeats;
  json["bad_crc"] = state.messages.damaged;
  json["refused"] = state.messages.refused;
  json["skipped"] = state.messages.skipped;
  return json;
}

// Says once that the tool asked for is not among those that are heard, while there is time to ask for another.
class MissingTool {
 public:
  explicit MissingTool(std::string tool) : tool_(std::move(tool)), told_(tool_.empty()) {}

  void look(const std::map<std::string, HeardTool>& tools, double now_s,
            const std::function<void(const std::string&)>& tell) {
    if (told_ || tools.empty()) return;
    if (tools.contains(tool_)) {
      told_ = true;
      return;
    }
    if (first_s_ < 0.0) first_s_ = now_s;
    if (now_s - first_s_ < kPatience) return;
    told_ = true;
    tell(fmt::format("warning: no tool '{}' so far, but {}; is one of them meant (--tool)?", excerpt(tool_),
                     names_of(tools)));
  }

 private:
  // A server sends its tools one after another, the slowest that are of use ten times a second.
  static constexpr double kPatience = 1.0;
  std::string tool_;
  bool told_;
  double first_s_ = -1.0;
};

Expected<void> write_recording(const ListenArguments& options, const std::string& where,
                               const PoseRecorder& recorder, const std::map<std::string, HeardTool>& tools) {
  if (recorder.rows() == 0)
    return refused("{}: the tool '{}' was never seen; move it into the tracker's sight", where,
                   recorder.tool());
  if (auto written = write_file(options.out, recorder.content()); !written) return written;
  if (options.tool.empty() && tools.size() > 1)
    notice(fmt::format("warning: only {} was recorded; there were {}: choose with --tool", recorder.tool(),
                       names_of(tools)));
  if (recorder.other_clock() > 0)
    notice(fmt::format("warning: {} left out: some had time stamps and some had not",
                       counted(recorder.other_clock(), "pose")));
  if (recorder.full())
    notice(fmt::format("warning: ended after {} poses, the most one file holds", kMostRecorded));
  return {};
}

Expected<void> listen_to_tracker(const ListenArguments& options) {
  std::string server = options.address;
  const Wire& wire = wire_of(server);
  std::vector<std::string> files;
  if (&wire == &kNdi) {
    auto place = drivers::ndi::split_place(server);
    server = std::move(place.server);
    files = std::move(place.files);
  }
  const auto address = drivers::network::parse_server(server, wire.protocol);
  if (!address) return tl::unexpected(address.error());
  const std::filesystem::path folder = std::filesystem::path(options.out).parent_path();
  std::error_code code;
  if (!folder.empty() && !std::filesystem::is_directory(folder, code))
    return wrong_use("{}: no such folder; make it first", excerpt(folder.string(), 160));
  const auto& stop = stop_requested();
  auto client = connect_to(wire, *address, files);
  if (!client) return tl::unexpected(client.error());
  const std::string where = address->text();
  notice(fmt::format("listening to {}{}", where, options.seconds > 0.0 ? "" : "; Ctrl-C ends"));

  std::map<std::string, HeardTool> tools;
  PoseRecorder recorder(options.tool);
  LiveLine live;
  const std::int64_t start = MonotonicClock<TrackerClock>::monotonic_ns();
  LinkNews link;
  MissingTool missing(options.tool);
  for (;;) {
    const bool last_look =
        stop || recorder.full() || (options.seconds > 0.0 && since(start) >= options.seconds);
    link.look((*client)->state(), since(start), [&](const char* what) {
      live.end();
      notice(fmt::format("{}: {}", where, what));
    });
    for (const auto& sample : (*client)->poll()) {
      const bool is_new = !tools.contains(sample.tool);
      auto& tool = tools[sample.tool];
      if (is_new) {
        tool.first_ns = sample.arrived_ns;
        live.end();
        notice(fmt::format("tool {}{}", sample.tool,
                           sample.server_time ? "" : " (without time stamps: time of arrival)"));
      }
      tool.last_ns = sample.arrived_ns;
      ++(sample.seen ? tool.poses : tool.unseen);
      if (!options.out.empty()) recorder.add(sample);
    }
    missing.look(tools, since(start), [&](const std::string& what) {
      live.end();
      notice(what);
    });
    live.show(tools, since(start));
    if (last_look) break;
    sleep_ms(20);
  }
  live.end();

  const auto state = (*client)->state();
  if (tools.empty()) return nothing_heard(where, wire, state);
  if (!options.tool.empty() && !tools.contains(options.tool))
    return refused("{}: no tool '{}' was heard; there were {}; use --tool with one of them", where,
                   excerpt(options.tool), names_of(tools));
  if (!options.out.empty())
    if (auto written = write_recording(options, where, recorder, tools); !written) return written;
  for (const auto& [number, what] : {std::pair{state.messages.damaged, "damaged on the way"},
                                     std::pair{state.messages.refused, "made no sense"}})
    if (number > 0)
      notice(
          fmt::format("warning: {} {}: {}", counted(number, "message"), what, excerpt(state.trouble, 200)));
  if (!options.json.empty()) return write_json(options.json, json_of(tools, state));
  if (options.out == "-") return {};
  for (const auto& [name, tool] : tools)
    fmt::print("{:<20} {}, {:.1f} Hz{}\n", excerpt(name), counted(tool.poses, "pose"), tool.rate_hz(),
               tool.unseen > 0 ? fmt::format(", {} times out of sight", tool.unseen) : "");
  return {};
}

struct TrackReplay {
  std::string file, listen, json;
  std::vector<std::string> transforms;
  double speed = 1.0, seconds = 0.0;
  bool loop = false, insecure = false;
};

Expected<void> replay_recording(const TrackReplay& options) {
  std::string place = options.listen;
  const Wire& wire = wire_of(place);
  if (place.empty()) place = std::to_string(wire.protocol.default_port);
  const auto address = drivers::network::parse_listen(place, wire.protocol, options.insecure);
  if (!address) return tl::unexpected(address.error());
  auto recording = drivers::network::read_recording(options.file, options.transforms);
  if (!recording) return tl::unexpected(recording.error());
  const auto& stop = stop_requested();
  std::set<std::string> names;
  for (const auto& pose : *recording) names.insert(pose.tool);
  auto publisher = listen_at(wire, *address, names);
  if (!publisher) return tl::unexpected(publisher.error());
  if (options.insecure)
    notice(fmt::format("warning: {} is neither encrypted nor guarded: anyone who reaches it sees the poses",
                       (*publisher)->address().text()));
  notice(fmt::format("serving {} of {} at {}; waiting for a client", counted(recording->size(), "pose"),
                     excerpt(fmt::format("{}", fmt::join(names, ", ")), 160),
                     (*publisher)->address().text()));

  const std::int64_t opened = MonotonicClock<TrackerClock>::monotonic_ns();
  const auto over = [&] { return stop || (options.seconds > 0.0 && since(opened) >= options.seconds); };
  while ((*publisher)->state().clients == 0 && !over()) sleep_ms(20);
  drivers::network::Replay replay(std::move(*recording), options.speed, options.loop);
  const std::int64_t start = MonotonicClock<TrackerClock>::monotonic_ns();
  std::size_t clients = 0;
  while (!over()) {
    if (const auto now = (*publisher)->state().clients; now != clients) {
      clients = now;
      notice(counted(clients, "client"));
    }
    while (const auto pose = replay.take(since(start))) {
      const auto sent =
          (*publisher)->publish(pose->tool, Instant<TrackerClock>::from_seconds(pose->time_s), pose->pose);
      if (!sent) return sent;
      if (over()) break;
    }
    const auto due = replay.next_due();
    if (!due) break;
    sleep_ms(std::clamp(static_cast<int>(1e3 * (*due - since(start))), 1, 50));
  }
  // The last poses may still be on their way to a client that is busy.
  static_cast<void>((*publisher)->drain(std::chrono::seconds(5)));
  const auto state = (*publisher)->state();
  if (!options.json.empty())
    return write_json(options.json, Json{{"published", state.published},
                                         {"sent", state.sent},
                                         {"dropped", state.dropped},
                                         {"clients", state.accepted},
                                         {"turned_away", state.turned_away},
                                         {"thrown_out", state.thrown_out}});
  fmt::print("{} published, {} sent to {}, {} dropped\n", counted(state.published, "pose"),
             counted(state.sent, "message"), counted(state.accepted, "client"), state.dropped);
  return {};
}

void add_tracker_listen(CLI::App& tracker) {
  auto* command = tracker.add_subcommand(
      "listen",
      "Listen to an OpenIGTLink or VRPN server or an NDI tracker: which tools, how often; record one");
  auto options = std::make_shared<ListenArguments>();
  command
      ->add_option("SERVER", options->address,
                   "HOST[:PORT] of an OpenIGTLink server, vrpn://HOST[:PORT], or "
                   "ndi://HOST[:PORT][/FILE.rom,...]; the "
                   "port is 18944, 3883 or 8765 where none is said")
      ->required();
  command->add_option("--tool", options->tool,
                      "The tool to record, as the server names it; default: the first heard");
  command->add_option("--seconds", options->seconds, "Stop after this many seconds; 0 = at Ctrl-C")
      ->check(at_least_zero())
      ->default_val(0.0);
  command->add_option("--out", options->out, "Write the tool's poses here as CSV (- = standard output)")
      ->type_name("FILE");
  command->add_option("--json", options->json, "Write the counts here; - = standard output")
      ->type_name("FILE");
  on(command, [options] { return listen_to_tracker(*options); });
}

void add_tracker_replay(CLI::App& tracker) {
  auto* command = tracker.add_subcommand(
      "replay", "Serve a recording as a live tracker, over OpenIGTLink, VRPN or as an NDI tracker");
  auto options = std::make_shared<TrackReplay>();
  command->add_option("FILE", options->file, "Sequence (.igs.mha) or other file of poses with times")
      ->required();
  command
      ->add_option(
          "--transform", options->transforms,
          "AToB of a sequence, or a chain of those in it; several may be named. Default: all of the file's")
      ->type_name("AToB")
      ->expected(1)
      ->take_all();
  command
      ->add_option(
          "--listen", options->listen,
          "[HOST:]PORT to serve at; vrpn://[[HOST:]PORT]: over VRPN; ndi://[[HOST:]PORT]: as an NDI tracker")
      ->default_val("18944");
  command->add_flag("--insecure", options->insecure,
                    "Serve beyond this machine: the protocol protects nothing");
  command->add_option("--speed", options->speed, "Times as fast as recorded")
      ->check(between(0.001, 1000.0))
      ->default_val(1.0);
  command->add_flag("--loop", options->loop, "Begin again at the end");
  command
      ->add_option("--seconds", options->seconds,
                   "Stop after this many seconds; 0 = at the recording's end, or Ctrl-C")
      ->check(at_least_zero())
      ->default_val(0.0);
  command->add_option("--json", options->json, "Write the counts here; - = standard output")
      ->type_name("FILE");
  on(command, [options] { return replay_recording(*options); });
}

}  // namespace

void add_tracker(CLI::App& program) {
  auto* tracker = program.add_subcommand(
      "tracker", "Trackers over OpenIGTLink and VRPN, and NDI's: listen, or play a recording as one");
  tracker->require_subcommand(1);
  add_tracker_listen(*tracker);
  add_tracker_replay(*tracker);
}

}  // namespace palpate::tools::commands
