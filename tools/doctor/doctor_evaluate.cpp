#include "tools/doctor/doctor_evaluate.h"

#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cstring>

#include "palpate/core/text.h"
#include "tools/doctor/doctor_findings.h"

namespace palpate::tools::doctor {
namespace {

// The loops spin for a tenth of each millisecond and work for less.
constexpr double kLeastRealTimeShare = 0.5;
// A laboratory with one camera takes some ten megabytes of the run folder.
constexpr std::uint64_t kLeastFreeBytes = 32ull << 20, kEnoughFreeBytes = 256ull << 20;
// The physics server admits 64 clients, each a file; libraries and the program have some dozens.
constexpr std::uint64_t kLeastOpenFiles = 64, kEnoughOpenFiles = 256;
// Beyond this the kernel's own figure says that nobody has looked for long.
constexpr std::int64_t kFarOffUs = 1'000'000;
constexpr std::uint64_t kCoarseTimerNs = 1000;
constexpr const char* kLimits =
    "as root: groupadd --system realtime; usermod --append --groups realtime USER; copy "
    "limits.d/palpate.conf "
    "(in share/ of the sources, share/palpate/ of an installation) to /etc/security/limits.d; log in anew";

std::string bytes_text(std::uint64_t bytes) {
  if (bytes >= 10ull << 30) return fmt::format("{} GiB", bytes >> 30);
  if (bytes >= 10ull << 20) return fmt::format("{} MiB", bytes >> 20);
  return fmt::format("{} KiB", bytes >> 10);
}
std::string limit_text(const std::optional<std::uint64_t>& limit) {
  return limit ? std::to_string(*limit) : "unlimited";
}

Finding preemption_of(const RealTimeFacts& facts) {
  constexpr const char* kName = "kernel";
  constexpr const char* kRealTimeKernel =
      "for hard deadlines a kernel with PREEMPT_RT (Debian: linux-image-rt-amd64)";
  const auto has = [&](const char* word) { return facts.kernel.find(word) != std::string::npos; };
  if (facts.kernel_real_time || has("PREEMPT_RT"))
    return fine("real time", kName, "preempted at once (PREEMPT_RT)");
  if (facts.preempt_argument == "full" || (has("PREEMPT") && !has("PREEMPT_DYNAMIC")))
    return note("real time", kName,
                "preempted mostly at once; deadlines may be missed by milliseconds now and then",
                kRealTimeKernel);
  if (has("PREEMPT_DYNAMIC"))
    return note("real time", kName,
                "preemption chosen at start, full not asked for; deadlines may be missed by milliseconds now "
                "and then",
                std::string("preempt=full on the kernel's command line; ") + kRealTimeKernel);
  return note("real time", kName, "gives way only here and there; deadlines may be missed by milliseconds",
              kRealTimeKernel);
}

Finding throttling_of(const RealTimeFacts& facts) {
  constexpr const char* kName = "throttling";
  if (!facts.rt_runtime_us || !facts.rt_period_us || *facts.rt_period_us <= 0)
    return fine("real time", kName, "not told by this kernel");
  if (*facts.rt_runtime_us < 0)
    return note("real time", kName, "off: a real-time thread that never sleeps would hold its core for good",
                "sysctl kernel.sched_rt_runtime_us=950000 keeps a way back");
  const double share = static_cast<double>(*facts.rt_runtime_us) / static_cast<double>(*facts.rt_period_us);
  const auto value = fmt::format("real-time threads get {:.0f} % of {:.0f} ms", 100.0 * share,
                                 static_cast<double>(*facts.rt_period_us) * 1e-3);
  if (share < kLeastRealTimeShare)
    return note("real time", kName, value + ", and then wait", "sysctl kernel.sched_rt_runtime_us=950000");
  return fine("real time", kName, value);
}

Finding governor_of(const RealTimeFacts& facts) {
  constexpr const char* kName = "frequency";
  if (facts.governors.empty())
    return fine("real time", kName, "not told: a virtual machine, or the processor governs itself");
  auto kinds = facts.governors;
  std::sort(kinds.begin(), kinds.end());
  kinds.erase(std::unique(kinds.begin(), kinds.end()), kinds.end());
  if (kinds == std::vector<std::string>{"performance"})
    return fine("real time", kName, "governor performance");
  return note("real time", kName, "governor " + listed(kinds) + ": a core that was idle starts slowly",
              "cpupower frequency-set -g performance (package linux-cpupower)");
}

Finding evaluate_server(const KeyFacts::Server& server) {
  constexpr const char* kArea = "keys";
  constexpr const char* kName = "server";
  const auto& answered = server.answered;
  switch (answered.who) {
    case transport::Answer::physics_server:
      return fine(kArea, kName,
                  fmt::format("{} answers, and lets us be {}", server.address,
                              transport::role_name(answered.role.value_or(transport::Role::observer))));
    case transport::Answer::nobody:
      return note(kArea, kName, server.address + " does not answer",
                  "start palpate physics --listen there; else look at firewalls and the address on the way");
    case transport::Answer::not_admitted:
      return obstacle(
          kArea, kName, server.address + " does not admit the key of this machine",
          "there: palpate keys authorize KEY --role graphics, with what palpate keys show prints here");
    case transport::Answer::stranger:
      break;
  }
  return obstacle(
      kArea, kName,
      server.address + " answers otherwise: " +
          (answered.trouble.empty() ? "no physics server with the key entered here" : answered.trouble),
      "there: palpate keys show; here: palpate keys trust ADDRESS KEY");
}

}  // namespace

std::string_view verdict_name(Verdict verdict) {
  constexpr std::array<std::string_view, 3> kNames{"ok", "worth knowing", "in the way"};
  return kNames[static_cast<std::size_t>(verdict)];
}

Findings evaluate(const RealTimeFacts& facts) {
  constexpr const char* kArea = "real time";
  Findings found;
  if (facts.grant.fifo()) {
    found.push_back(fine(kArea, "SCHED_FIFO", fmt::format("priority {} granted", facts.grant.fifo_priority)));
  } else {
    found.push_back(
        note(kArea, "SCHED_FIFO",
             fmt::format("refused ({}), RLIMIT_RTPRIO is {}: the loops run, and late where others work",
                         std::strerror(facts.grant.fifo_errno), limit_text(facts.rtprio_limit)),
             kLimits));
  }
  const std::string limit = facts.memlock_limit ? bytes_text(*facts.memlock_limit) : std::string("unlimited");
  if (!facts.grant.memory_locked) {
    found.push_back(note(kArea, "memory",
                         fmt::format("cannot be locked ({}), RLIMIT_MEMLOCK is {}: a page fetched from disk "
                                     "takes milliseconds",
                                     std::strerror(facts.grant.memory_errno), limit),
                         kLimits));
  } else {
    found.push_back(fine(kArea, "memory", fmt::format("can be locked, RLIMIT_MEMLOCK is {}", limit)));
  }
  found.push_back(preemption_of(facts));
  found.push_back(throttling_of(facts));
  found.push_back(governor_of(facts));
  if (facts.cores < 2) {
    found.push_back(note(kArea, "cores", "1: the loops share it with everything else",
                         "give the physics server a machine with two cores or more"));
  } else {
    found.push_back(fine(kArea, "cores", std::to_string(facts.cores)));
  }
  if (facts.timer_resolution_ns && *facts.timer_resolution_ns > kCoarseTimerNs) {
    found.push_back(
        obstacle(kArea, "timers",
                 fmt::format("end every {} us only: no loop keeps 1 kHz", *facts.timer_resolution_ns / 1000),
                 "a kernel with high-resolution timers (CONFIG_HIGH_RES_TIMERS, no highres=off)"));
  } else {
    found.push_back(fine(kArea, "timers", "of high resolution"));
  }
  return found;
}

Findings evaluate(const ClockFacts& facts) {
  constexpr const char* kArea = "clock";
  constexpr const char* kInstall = "apt-get install chrony, if dates matter (docs/two-machines.md)";
  Findings found;
  const std::string keepers = facts.keepers.empty() ? "a program not seen from here" : listed(facts.keepers);
  if (!facts.known) {
    found.push_back(note(kArea, "wall clock", "the kernel tells nothing of it: " + facts.why_unknown,
                         "look on the machine itself: chronyc tracking, or timedatectl"));
  } else if (!facts.synchronised) {
    found.push_back(
        facts.keepers.empty()
            ? note(kArea, "wall clock",
                   "kept by nobody: dates in rig files and reports drift; states do not depend on it",
                   kInstall)
            : note(kArea, "wall clock", keepers + " runs, and has not set it yet",
                   "wait a minute, then see chronyc tracking or timedatectl: it may reach no server"));
  } else if (facts.maximum_error_us > kFarOffUs) {
    found.push_back(note(kArea, "wall clock",
                         fmt::format("kept by {}, may be off by {:.1f} s", keepers,
                                     static_cast<double>(facts.maximum_error_us) * 1e-6),
                         "see chronyc tracking or timedatectl: its server may be far away or gone"));
  } else {
    found.push_back(fine(kArea, "wall clock",
                         fmt::format("kept by {}, off by {} us as estimated, {} us at most", keepers,
                                     facts.estimated_error_us, facts.maximum_error_us)));
  }
  constexpr std::array<std::string_view, 4> kSlow{"hpet", "acpi_pm", "jiffies", "pit"};
  if (facts.source.empty()) {
    found.push_back(fine(kArea, "source", "not told"));
  } else if (std::find(kSlow.begin(), kSlow.end(), facts.source) != kSlow.end()) {
    found.push_back(note(kArea, "source",
                         facts.source + ": each look at the clock takes a microsecond or more",
                         "see dmesg for why the kernel does not trust tsc; clocksource=tsc asks for it"));
  } else {
    found.push_back(fine(kArea, "source", facts.source));
  }
  return found;
}

Findings evaluate(const SocketFacts& facts) {
  constexpr const char* kArea = "sockets";
  Findings found;
  const std::string folder = facts.folder.string();
  if (!facts.folder_problem.empty()) {
    found.push_back(told(Verdict::in_the_way, kArea, "run folder", facts.folder_problem));
  } else if (!facts.exists) {
    found.push_back(fine(kArea, "run folder", folder + ", made by the first server"));
  } else {
    found.push_back(fine(kArea, "run folder", fmt::format("{}, mode {:o}", folder, facts.mode)));
  }
  if (facts.path_bytes > facts.path_limit) {
    found.push_back(obstacle(kArea, "unix socket",
                             fmt::format("{}: {} bytes, a socket's path has at most {}", folder,
                                         facts.path_bytes, facts.path_limit),
                             "set XDG_RUNTIME_DIR to a shorter path"));
  } else if (!facts.socket_problem.empty()) {
    found.push_back(obstacle(kArea, "unix socket", "cannot be made there: " + facts.socket_problem,
                             "set XDG_RUNTIME_DIR to a folder of your own where sockets can be made"));
  } else {
    found.push_back(
        fine(kArea, "unix socket", facts.exists ? "can be made there" : "its folder can be made"));
  }
  if (!facts.leftovers.empty())
    found.push_back(note(kArea, "leftovers", "of dead servers: " + listed(facts.leftovers),
                         "nothing: the next server at that address takes their place"));
  switch (facts.at_default.who) {
    case transport::Answer::physics_server:
      found.push_back(fine(kArea, "physics server", "answers at the default address"));
      break;
    case transport::Answer::nobody:
      found.push_back(
          fine(kArea, "physics server", "none at the default address; palpate physics starts one"));
      break;
    default:
      found.push_back(obstacle(kArea, "physics server",
                               "something listens at the default address and does not answer",
                               "stop it, or look whether it is stopped or busy (ps, ss -xlp)"));
  }
  found.push_back(fine(kArea, "laboratory",
                       facts.laboratories.empty() ? "none is open; palpate world run opens a simulated one"
                                                  : "open: " + listed(facts.laboratories)));
  return found;
}

Findings evaluate(const ListenFacts& facts) {
  constexpr const char* kArea = "listen";
  Finding result;
  if (!facts.problem.empty()) {
    result = told(Verdict::in_the_way, kArea, "", facts.problem);
  } else if (facts.answered.who == transport::Answer::physics_server) {
    result = fine(kArea, "", "a physics server answers there");
  } else if (facts.answered.who == transport::Answer::not_admitted) {
    result = fine(kArea, "", "a physics server with the key of this machine listens there");
  } else if (facts.answered.who == transport::Answer::stranger || facts.listening.in_use) {
    result =
        obstacle(kArea, "", "in use by what does not answer as a physics server with the key of this machine",
                 "stop it (ss -tlnp names it) or listen at another address");
  } else if (!facts.local && !facts.listening.possible) {
    result = obstacle(
        kArea, "", "nobody can listen there: " + facts.listening.reason,
        "give an address of this machine (ip -brief address), or tcp://*:PORT, and a port above 1023");
  } else {
    result = fine(kArea, "", "free");
  }
  result.name = excerpt(facts.address, 100);
  return {result};
}

Findings evaluate(const KeyFacts& facts) {
  constexpr const char* kArea = "keys";
  const Verdict missing = facts.needed ? Verdict::in_the_way : Verdict::ok;
  Findings found;
  if (!facts.encryption)
    found.push_back(finding(kArea, "encryption", facts.needed ? Verdict::in_the_way : Verdict::worth_knowing,
                            "this ZeroMQ has no CURVE: tcp:// works with --insecure only",
                            "install a libzmq with CURVE (libsodium)"));
  if (!facts.folder_problem.empty()) {
    found.push_back(told(missing == Verdict::ok ? Verdict::worth_knowing : missing, kArea, "folder",
                         facts.folder_problem));
    return found;
  }
  const std::string folder = facts.folder.string();
  const auto no_pair = [&] {
    return finding(kArea, "pair", missing, "none in " + folder + "; only tcp:// needs keys",
                   facts.needed ? "palpate keys new" : "");
  };
  if (facts.folder_mode == 0) {
    found.push_back(no_pair());
    return found;
  }
  if ((facts.folder_mode & 0022) != 0) {
    found.push_back(note(kArea, "folder",
                         fmt::format("{}: others can write to it (mode {:o})", folder, facts.folder_mode),
                         "chmod 700 " + folder));
  } else {
    found.push_back(fine(kArea, "folder", fmt::format("{}, mode {:o}", folder, facts.folder_mode)));
  }
  if (!facts.pair_there) {
    found.push_back(no_pair());
  } else if (!facts.pair_problem.empty()) {
    found.push_back(told(Verdict::in_the_way, kArea, "pair", facts.pair_problem));
  } else {
    found.push_back(fine(kArea, "pair", "public key " + facts.public_key));
  }
  if (!facts.admitted_problem.empty()) {
    found.push_back(told(Verdict::in_the_way, kArea, "admitted", facts.admitted_problem));
  } else if (facts.admitted.empty()) {
    found.push_back(
        facts.needed ? note(kArea, "admitted", "nobody",
                            "palpate keys authorize KEY --role graphics --name NAME, with the client's key")
                     : fine(kArea, "admitted", "nobody"));
  } else {
    std::array<int, 3> roles{};
    for (const auto& key : facts.admitted) ++roles[static_cast<std::size_t>(key.role)];
    found.push_back(
        fine(kArea, "admitted",
             fmt::format("{} as observer, {} as graphics, {} as operator", roles[0], roles[1], roles[2])));
  }
  for (const auto& complaint : facts.complaints)
    found.push_back(note(kArea, "line", complaint, "until it is mended it admits nobody"));
  if (!facts.servers_problem.empty()) {
    found.push_back(obstacle(kArea, "known servers", facts.servers_problem,
                             "mend the line, or take it out and use palpate keys trust"));
  } else {
    found.push_back(fine(kArea, "known servers", std::to_string(facts.servers.size())));
  }
  for (const auto& server : facts.servers) found.push_back(evaluate_server(server));
  return found;
}

Findings evaluate(const plugin::Report& plugins) {
  constexpr const char* kArea = "plug-in";
  Findings found;
  for (const auto& one : plugins.loaded) {
    std::string adds = one.applications.empty() ? "" : "applications " + listed(one.applications) + ", ";
    if (!one.drivers.empty()) adds += "drivers " + listed(one.drivers) + ", ";
    found.push_back(fine(kArea, one.name.c_str(), adds + one.file.string()));
  }
  for (const auto& why : plugins.skipped)
    found.push_back(told(Verdict::worth_knowing, kArea, "left out", why));
  return found;
}

Findings evaluate(const SpaceFacts& facts) {
  constexpr const char* kArea = "space";
  Findings found;
  if (!facts.free_bytes) {
    found.push_back(note(kArea, "run folder", facts.folder.string() + ": its free space is not told",
                         "df -h " + facts.folder.string()));
  } else {
    const std::string value =
        fmt::format("{} free in {}", bytes_text(*facts.free_bytes), facts.folder.string());
    const std::string remedy = "remove what nobody needs there, or set XDG_RUNTIME_DIR elsewhere";
    found.push_back(*facts.free_bytes < kLeastFreeBytes    ? obstacle(kArea, "run folder", value, remedy)
                    : *facts.free_bytes < kEnoughFreeBytes ? note(kArea, "run folder", value, remedy)
                                                           : fine(kArea, "run folder", value));
  }
  const std::string limit = limit_text(facts.open_files);
  const std::string remedy = "ulimit -n 1024, or a nofile entry in limits.conf";
  found.push_back(facts.open_files && *facts.open_files < kLeastOpenFiles
                      ? obstacle(kArea, "open files", limit + ": too few for a server", remedy)
                  : facts.open_files && *facts.open_files < kEnoughOpenFiles
                      ? note(kArea, "open files", limit + ": too few for 64 clients", remedy)
                      : fine(kArea, "open files", limit));
  return found;
}

Findings evaluate(const Facts& facts) {
  Findings found;
  const auto add = [&](Findings more) {
    for (auto& finding : more) found.push_back(std::move(finding));
  };
  add(evaluate(facts.real_time));
  add(evaluate(facts.clock));
  add(evaluate(facts.sockets));
  if (facts.listen) add(evaluate(*facts.listen));
  add(evaluate(facts.keys));
  add(evaluate(facts.graphics));
  add(evaluate(facts.desktop));
  add(evaluate(facts.devices));
  add(evaluate(facts.space));
  add(evaluate(facts.libraries));
  add(evaluate(facts.plugins));
  return found;
}

Json to_json(const Findings& findings) {
  Json json;
  json["findings"] = Json::array();
  std::array<int, 3> counts{};
  for (const auto& finding : findings) {
    json["findings"].push_back({{"area", finding.area},
                                {"name", finding.name},
                                {"verdict", verdict_name(finding.verdict)},
                                {"value", finding.value},
                                {"remedy", finding.remedy}});
    ++counts[static_cast<std::size_t>(finding.verdict)];
  }
  json["ok"] = counts[0];
  json["worth_knowing"] = counts[1];
  json["in_the_way"] = counts[2];
  return json;
}

}  // namespace palpate::tools::doctor
