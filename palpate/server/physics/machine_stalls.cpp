#include "palpate/server/physics/machine_stalls.h"

#include <sched.h>

#include <algorithm>

#include "palpate/time/real_time.h"

namespace palpate::server::physics {
namespace {

std::vector<int> cores_in_use(std::size_t most) {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> cores;
  if (sched_getaffinity(0, sizeof set, &set) != 0) return {-1};
  for (int core = 0; core < CPU_SETSIZE && cores.size() < most; ++core)
    if (CPU_ISSET(core, &set)) cores.push_back(core);
  return cores;
}

}  // namespace

MachineStalls::MachineStalls(Clock<PhysicsClock>& clock, bool real_time) {
  for (const int core : cores_in_use(kMostCores)) {
    Watch& watch = *watches_.emplace_back(std::make_unique<Watch>());
    watch.kept.reserve(64);
    watch.thread =
        std::thread([this, &watch, &clock, core, real_time] { look(watch, clock, core, real_time); });
  }
}

void MachineStalls::look(Watch& watch, Clock<PhysicsClock>& clock, int core, bool real_time) {
  name_and_pin_thread("palpate-stalls", core);
  constexpr int kAboveTheLoops = 91;  // and above their watchdog
  if (real_time) enter_real_time(kAboveTheLoops);
  while (!stopping_.load(std::memory_order_relaxed)) {
    const auto wake = clock.now() + kLook;
    clock.sleep_until(wake);
    const auto now = clock.now();
    if (now - wake < kStall) continue;
    ++watch.count;
    if (watch.kept.size() < kMostKept) watch.kept.push_back({wake, now, core});
  }
}

void MachineStalls::stop() {
  stopping_.store(true, std::memory_order_relaxed);
  for (const auto& watch : watches_) {
    watch->thread.join();
    stalls_.insert(stalls_.end(), watch->kept.begin(), watch->kept.end());
    count_ += watch->count;
  }
  watches_.clear();
  std::sort(stalls_.begin(), stalls_.end(), [](const auto& a, const auto& b) { return a.from < b.from; });
}

Duration MachineStalls::longest() const {
  Duration longest{0};
  for (const MachineStall& stall : stalls_) longest = std::max(longest, stall.to - stall.from);
  return longest;
}

bool within_stall(const haptics::LoggedTrip& trip, const std::vector<MachineStall>& stalls) {
  // An outage that was noticed at its end, by a late tick, had begun so much before.
  const auto noticed = std::chrono::milliseconds(5);
  const auto from = trip.trip.time - std::max(Duration(0), seconds(trip.outage_s) - seconds(trip.away_s)) -
                    noticed,
             to = trip.trip.time + seconds(trip.away_s);
  return std::any_of(stalls.begin(), stalls.end(),
                     [&](const MachineStall& stall) { return stall.from <= to && from <= stall.to; });
}

}  // namespace palpate::server::physics
