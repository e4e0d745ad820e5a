// How late the haptic loop's ticks begin, beside cyclictest at the same rate and priority: 1 and 4 kHz, idle
// and beside processes that compute, copy memory and wake each other.
//
// Each round runs, one after the other, our loop (PeriodicLoop with a whole HapticLoop tick: arm, chain,
// records), the same without spinning before deadlines, cyclictest, and cyclictest again: the rival against
// itself is the noise. Quantiles are of all rounds together; ratios are medians over the rounds. Needs
// cyclictest (package rt-tests) and the right to SCHED_FIFO.
//
//   haptic_loop_bench [rounds = 10] [seconds per run = 1]
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "palpate/core/statistics.h"
#include "palpate/haptics/haptic_loop.h"
#include "palpate/time/periodic_loop.h"

namespace {

using namespace palpate;

constexpr int kPriority = 80;
constexpr int kMostUs = 20000;  // of cyclictest's histogram

class StillArm : public device::ArmDevice {
 public:
  device::ArmSample read() override {
    sample_.stamp += Duration(1000);
    return sample_;
  }
  void command(const Vector3& f) override { force_ = f; }
  void let_go() noexcept override {}

 private:
  device::ArmSample sample_{{}, {0.1, 0.5, 0.3}, {0.2, -0.1, 0.3}};
  Vector3 force_ = Vector3::Zero();
};

// Lateness in ns, sorted, with how often.
struct Lateness {
  std::map<std::int64_t, std::uint64_t> counts;
  std::uint64_t ticks = 0;
  void add(std::int64_t ns, std::uint64_t n) {
    counts[ns] += n;
    ticks += n;
  }
  void add(const Lateness& other) {
    for (const auto& [ns, n] : other.counts) add(ns, n);
  }
  double us(double q) const {
    auto left = static_cast<std::uint64_t>(q * static_cast<double>(ticks));
    for (const auto& [ns, n] : counts) {
      if (n > left) return 1e-3 * static_cast<double>(ns);
      left -= n;
    }
    return counts.empty() ? 0.0 : 1e-3 * static_cast<double>(counts.rbegin()->first);
  }
};

// Each tick's lateness is kept itself, so that quantiles are not those of histogram bins.
Lateness our_loop(double rate_hz, double seconds_long, Duration spin) {
  StillArm arm;
  TripleBuffer<haptics::HapticInput> input;
  TripleBuffer<scene::TipState> output;
  haptics::HapticSettings settings{.permit = haptics::ForcePermit::of_simulated_arm()};
  settings.period = seconds(1.0 / rate_hz);
  haptics::HapticLoop haptic(arm, rig::ArmCalibration{}, {}, settings, input, output);
  const MonotonicClock<PhysicsClock> reader;
  MonotonicClock<PhysicsClock> clock;
  const auto wanted = static_cast<std::size_t>(seconds_long * rate_hz);
  std::vector<std::int64_t> late(wanted, -1);
  std::atomic<std::size_t> done{0};
  haptics::HapticInput message;
  message.continuous = {0.0, 1.0, 0.0};
  {
    PeriodicLoop<PhysicsClock> loop(clock,
                                    {.rate_hz = rate_hz,
                                     .name = "bench-haptic",
                                     .real_time = true,
                                     .priority = kPriority,
                                     .spin = spin,
                                     .keep_cores_awake = true},
                                    [&](Instant<PhysicsClock> due) {
                                      const auto begun = reader.now();
                                      message.time = due;
                                      input.write(message);
                                      haptic.tick(due);
                                      const std::size_t i = done.load(std::memory_order_relaxed);
                                      if (i >= wanted) return;
                                      late[i] = (begun - due).count();
                                      done.store(i + 1, std::memory_order_release);
                                    });
    if (!loop.grant().fifo()) throw std::runtime_error(loop.grant().describe());
    while (done.load(std::memory_order_acquire) < wanted)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  Lateness all;
  for (const auto ns : late) all.add(std::max<std::int64_t>(0, ns), 1);
  return all;
}

Lateness cyclictest(double rate_hz, double seconds_long) {
  const std::string command = fmt::format(
      "cyclictest --quiet --mlockall --threads=1 --priority={} --interval={:.0f} --loops={:.0f} "
      "--histogram={} 2>&1",
      kPriority, 1e6 / rate_hz, seconds_long * rate_hz, kMostUs);
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run cyclictest");
  Lateness all;
  std::array<char, 512> line;
  std::string said;
  while (std::fgets(line.data(), line.size(), pipe) != nullptr) {
    long us = 0, count = 0;
    if (std::sscanf(line.data(), "# Histogram Overflows: %ld", &count) == 1) {
      if (count > 0) all.add(1000LL * kMostUs, static_cast<std::uint64_t>(count));
    } else if (line[0] != '#' && std::sscanf(line.data(), "%ld %ld", &us, &count) == 2) {
      if (count > 0) all.add(1000 * us, static_cast<std::uint64_t>(count));
    } else if (line[0] != '#') {
      said += line.data();
    }
  }
  if (::pclose(pipe) != 0 || all.ticks == 0)
    throw std::runtime_error("cyclictest (package rt-tests) does not run here: " + said);
  return all;
}

template <typename Work>
pid_t child(Work work) {
  const pid_t pid = ::fork();
  if (pid != 0) return pid;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  work();
  ::_exit(0);
}

// Two that compute, one that copies 64 MB to and fro, a pair that wakes each other over a pipe.
std::vector<pid_t> load() {
  std::vector<pid_t> all;
  for (int i = 0; i < 2; ++i)
    all.push_back(child([] {
      for (volatile std::uint64_t x = 0;;) x = x + 1;
    }));
  all.push_back(child([] {
    std::vector<char> a(32 << 20, 1), b(32 << 20);
    while (true) {
      std::memcpy(b.data(), a.data(), a.size());
      std::swap(a, b);
    }
  }));
  all.push_back(child([] {
    int there[2], back[2];
    if (::pipe(there) != 0 || ::pipe(back) != 0) return;
    char c = 0;
    if (::fork() == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      while (::read(there[0], &c, 1) == 1 && ::write(back[1], &c, 1) == 1) {
      }
      ::_exit(0);
    }
    while (::write(there[1], &c, 1) == 1 && ::read(back[0], &c, 1) == 1) {
    }
  }));
  return all;
}

void compare(const char* company, double rate_hz, int rounds, double seconds_long) {
  constexpr std::array names{"ours", "ours, no spin", "cyclictest", "again"};
  std::array<Lateness, 4> all;
  std::array<std::vector<double>, 4> ratios;  // of p99.9 to cyclictest's, round by round
  for (int round = 0; round < rounds; ++round) {
    std::array<Lateness, 4> now;
    // Every second round the other way round: what drifts meets all alike.
    for (int k = 0; k < 4; ++k) {
      const int leg = round % 2 == 0 ? k : 3 - k;
      auto& here = now[static_cast<std::size_t>(leg)];
      if (leg < 2) {
        here = our_loop(rate_hz, seconds_long, leg == 0 ? Duration(100'000) : Duration(0));
      } else {
        here = cyclictest(rate_hz, seconds_long);
      }
    }
    const double beside = std::max(1.0, now[2].us(0.999));  // cyclictest counts whole microseconds
    for (std::size_t i = 0; i < 4; ++i) {
      ratios[i].push_back(now[i].us(0.999) / beside);
      all[i].add(now[i]);
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    fmt::print("{:<7} {:>4.0f} Hz  {:<14} {:>8} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.1f}   {:>7.3f}\n", company,
               rate_hz, names[i], all[i].ticks, all[i].us(0.5), all[i].us(0.99), all[i].us(0.999),
               all[i].us(1.0), median(ratios[i]));
  }
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 10;
    const double seconds_long = argc > 2 ? std::max(0.2, std::atof(argv[2])) : 1.0;
    fmt::print("{:<7} {:>7}  {:<14} {:>8} {:>8} {:>8} {:>8} {:>8}   {}\n", "", "", "late, us", "ticks", "p50",
               "p99", "p99.9", "max", "p99.9 / cyclictest's, median of rounds");
    for (const double rate : {1000.0, 4000.0}) compare("idle", rate, rounds, seconds_long);
    const auto busy = load();
    for (const double rate : {1000.0, 4000.0}) compare("loaded", rate, rounds, seconds_long);
    for (const pid_t pid : busy) {
      ::kill(pid, SIGKILL);
      ::waitpid(pid, nullptr, 0);
    }
  } catch (const std::exception& failure) {
    fmt::print(stderr, "haptic_loop_bench: {}\n", failure.what());
    return 1;
  }
}
