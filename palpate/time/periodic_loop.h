// Runs a callable at a fixed rate in a thread of its own, and counts how well
// that went.
//
// Deadlines lie on a fixed grid from the start. Under SCHED_FIFO the thread
// sleeps until shortly before a deadline and spins for the rest; under the
// ordinary scheduler it only sleeps, because a thread that spins there is taken
// off its core just when it should run. Deadlines that passed while the
// callable was still at work are skipped and counted, never made up for in a
// burst. A tick that begins a period late or more is told the time at which it
// begins, and not its deadline: whoever stood still has to know it. Measurements behind these choices:
// docs/theory/clocks.md.
//
// The callable runs in the loop's thread; it must not throw, and what it does
// at a kilohertz must not lock or allocate. The loop itself does neither.
// statistics() may be called from any thread at any time.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "palpate/core/crash_words.h"
#include "palpate/time/clock.h"
#include "palpate/time/jitter_histogram.h"
#include "palpate/time/real_time.h"

namespace palpate::inline time {

struct PeriodicLoopSettings {
  double rate_hz = 1000.0;
  const char* name = "palpate-loop";  // as tools that list threads show it; 15 characters
  bool real_time = true;              // ask for SCHED_FIFO and locked memory; the loop runs
                                      // without them as well
  int priority = 80;                  // of SCHED_FIFO, 1 ... 99
  Duration spin =
      std::chrono::microseconds(100);  // before a deadline, under SCHED_FIFO only; 0 on a virtual clock
  bool keep_cores_awake = false;       // under SCHED_FIFO only: CoresAwake while the loop runs
  int cpu = -1;                        // bind to this core; -1: any
};

struct LoopStatistics {
  std::uint64_t ticks = 0;
  std::uint64_t overruns = 0;         // ticks that were still at work at the next deadline
  std::uint64_t missed = 0;           // deadlines skipped because of that
  std::uint64_t missed_in_a_row = 0;  // the most of them one after the other
  // Begin of a tick after its deadline; of skipped ones nothing is known. A loop that spins begins within
  // nanoseconds unless its core was taken from it: what the machine is worth stands in late_max and missed.
  Duration late_p50{0}, late_p99{0}, late_p999{0}, late_max{0};
  Duration busy_p50{0}, busy_p99{0}, busy_max{0};  // what the callable took
  double rate_hz = 0.0;  // ticks a second, from the first period's begin to now or the loop's end
};

template <typename C>
class PeriodicLoop {
 public:
  using Work = std::function<void(Instant<C> now)>;

  // Starts at once; the first deadline is one period from now. The clock must
  // outlive the loop.
  PeriodicLoop(Clock<C>& clock, const PeriodicLoopSettings& settings, Work work)
      : clock_(clock), settings_(settings), work_(std::move(work)) {
    if (!(settings.rate_hz > 0.0) || settings.rate_hz > 1e5)
      throw std::invalid_argument("PeriodicLoop: rate_hz must lie in (0, 100000]");
    thread_ = std::thread([this] { run(); });
  }
  ~PeriodicLoop() { stop(); }
  PeriodicLoop(const PeriodicLoop&) = delete;
  PeriodicLoop& operator=(const PeriodicLoop&) = delete;

  // Returns when the thread has ended, at the latest after the tick under way
  // and one period. Not from the callable.
  void stop() {
    stopping_.store(true, std::memory_order_relaxed);
    if (thread_.joinable()) thread_.join();
  }

  LoopStatistics statistics() const {
    return {ticks_.load(std::memory_order_relaxed),
            overruns_.load(std::memory_order_relaxed),
            missed_.load(std::memory_order_relaxed),
            missed_in_a_row_.load(std::memory_order_relaxed),
            late_.quantile(0.5),
            late_.quantile(0.99),
            late_.quantile(0.999),
            late_.max(),
            busy_.quantile(0.5),
            busy_.quantile(0.99),
            busy_.max(),
            rate_hz()};
  }

  // Begin of each tick after its deadline; any thread, any time.
  const JitterHistogram& lateness() const { return late_; }

  // What the scheduler granted. Waits until the thread has asked.
  const RealTimeGrant& grant() const {
    granted_.wait(false);
    return grant_;
  }

 private:
  Instant<C> deadline(Instant<C> start, std::uint64_t k) const {
    return start + Duration(std::llround(static_cast<double>(k) * (1e9 / settings_.rate_hz)));
  }

  double rate_hz() const {
    const std::int64_t begun = begun_ns_.load(std::memory_order_relaxed),
                       ended = ended_ns_.load(std::memory_order_relaxed);
    if (begun == kNever) return 0.0;
    const double long_s = 1e-9 * static_cast<double>((ended == kNever ? clock_.now().ns() : ended) - begun);
    return long_s > 0.0 ? static_cast<double>(ticks_.load(std::memory_order_relaxed)) / long_s : 0.0;
  }

  void run() {
    name_and_pin_thread(settings_.name, settings_.cpu);
    give_crash_stack();
    if (settings_.real_time) {
      grant_ = enter_real_time(settings_.priority);
    } else {
      sharpen_sleep();
    }
    granted_.store(true);
    granted_.notify_all();
    std::optional<CoresAwake> awake;
    if (grant_.fifo() && settings_.keep_cores_awake) awake.emplace();
    const Duration spin = grant_.fifo() ? settings_.spin : Duration(0);
    const Instant<C> start = clock_.now();
    begun_ns_.store(start.ns(), std::memory_order_relaxed);
    const Duration period = deadline(start, 1) - start;
    for (std::uint64_t k = 1; !stopping_.load(std::memory_order_relaxed); ++k) {
      const Instant<C> due = deadline(start, k);
      clock_.sleep_until(due - spin);
      Instant<C> begun = clock_.now();
      while (begun < due) begun = clock_.now();
      if (stopping_.load(std::memory_order_relaxed)) break;
      work_(begun - due < period ? due : begun);
      const Instant<C> ended = clock_.now();
      late_.add(begun - due);
      busy_.add(ended - begun);
      increase(ticks_, 1);
      if (ended < deadline(start, k + 1)) continue;
      increase(overruns_, 1);
      const std::uint64_t before = k;
      k = std::max(k, static_cast<std::uint64_t>(to_seconds(ended - start) * settings_.rate_hz) - 1);
      while (deadline(start, k + 1) <= ended) ++k;
      increase(missed_, k - before);
      if (k - before > missed_in_a_row_.load(std::memory_order_relaxed))
        missed_in_a_row_.store(k - before, std::memory_order_relaxed);
    }
    ended_ns_.store(clock_.now().ns(), std::memory_order_relaxed);
  }

  static void increase(std::atomic<std::uint64_t>& counter, std::uint64_t by) {
    counter.store(counter.load(std::memory_order_relaxed) + by, std::memory_order_relaxed);
  }

  Clock<C>& clock_;
  PeriodicLoopSettings settings_;
  Work work_;
  JitterHistogram late_, busy_;
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();
  std::atomic<std::int64_t> begun_ns_{kNever}, ended_ns_{kNever};
  std::atomic<std::uint64_t> ticks_{0}, overruns_{0}, missed_{0}, missed_in_a_row_{0};
  RealTimeGrant grant_;
  std::atomic<bool> granted_{false}, stopping_{false};
  std::thread thread_;
};

}  // namespace palpate::inline time
