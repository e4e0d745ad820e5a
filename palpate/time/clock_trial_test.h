// For tests: ClockSync over a simulated network to a peer whose clock has a known truth. The local clock is
// the time of the simulation.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/time/clock_model.h"

namespace palpate::inline time::testing {

// Each message takes the shortest way, exponential jitter and sometimes more. Defaults: what was measured on
// a loopback connection with bare time stamps in user space.
struct Network {
  double forth_s = 45e-6, back_s = 45e-6;                     // shortest way
  double wake_s = 40e-6;                                      // how much later the server wakes ...
  double jitter_s = 5e-6, held_up = 0.0, held_up_s = 1.2e-3;  // a share of the messages is held up
  double tail_s =
      0.0;  // scale of a heavy tail on every message: beyond d with (1 + d / scale)^-1.1, to 0.5 s
  double congested_every_s = 0.0, congested_for_s = 0.0,
         queue_s = 0.0;   // full queues at the end of each turn, one way at a time
  int train = 1;          // exchanges that follow each other at once ...
  double awake_s = 0.0;   // ... and how much later the server wakes for all but the first
  double spread_s = 0.0;  // evenly distributed on top of each way: no trip is quick
};

// Leads by offset_s and gains drift_ppm, which swings by wander_ppm and rises by warming_ppm_s.
struct Peer {
  double offset_s = 1.234567, drift_ppm = 80.0, wander_ppm = 2.0, wander_period_s = 30.0, warming_ppm_s = 0.0;
  std::int64_t at(double t) const {
    const double w = 2.0 * M_PI / wander_period_s;
    return std::llround((t + offset_s + drift_ppm * 1e-6 * t + 0.5e-6 * warming_ppm_s * t * t +
                         wander_ppm * 1e-6 / w * (1.0 - std::cos(w * t))) *
                        1e9);
  }
};

struct Trial {
  using Sync = ClockSync<GraphicsClock, PhysicsClock>;
  Network network;
  Peer peer;
  Sync sync;
  Random random{3, "exchange"};
  std::vector<double> errors;
  int outside = 0;
  double done = 0.0;  // when the last answer came

  double delay(double t, bool forth) {
    double d = forth ? network.forth_s : network.back_s;
    d -= network.jitter_s * std::log(1.0 - random.uniform());
    if (random.chance(network.held_up)) d -= network.held_up_s * std::log(1.0 - random.uniform());
    if (network.spread_s > 0.0) d += network.spread_s * random.uniform();
    if (network.tail_s > 0.0)
      d += std::min(0.5, network.tail_s * (std::pow(1.0 - random.uniform(), -1.0 / 1.1) - 1.0));
    if (network.congested_every_s > 0.0) {
      const double turn = std::floor(t / network.congested_every_s);
      const bool full = (turn + 1.0) * network.congested_every_s - t < network.congested_for_s;
      if (full && forth == (std::fmod(turn, 2.0) < 1.0))
        d += network.queue_s * (0.3 + 0.7 * random.uniform());
    }
    return d;
  }
  // One train; the result of its last exchange, or the restart in it.
  Sync::Result exchange(double t) {
    auto result = Sync::Result::used;
    for (int i = 0; i < network.train; ++i) {
      const double arrives = t + delay(t, true) + (i == 0 ? network.wake_s : network.awake_s);
      const double answered = arrives + 10e-6;
      done = answered + delay(answered, false);
      const auto next = sync.add({seconds(t)}, {Duration(peer.at(arrives))}, {Duration(peer.at(answered))},
                                 {seconds(done)});
      if (result != Sync::Result::restarted) result = next;
      t = done;
    }
    return result;
  }
  double error(double t) const {
    return 1e-9 * static_cast<double>(
                      (sync.model().to({seconds(t)}) - Instant<PhysicsClock>{Duration(peer.at(t))}).count());
  }
  double stated(double t) const { return to_seconds(sync.model().uncertainty({seconds(t)})); }
  // Looks just before the next exchange, where the model is oldest, and halfway there.
  void run(double from, double until) {
    for (double t = from; t < until;) {
      exchange(t);
      const double next = t + to_seconds(sync.interval());
      for (const double later : {0.5 * (t + next), next}) {
        outside += std::abs(error(later)) > stated(later) ? 1 : 0;
        errors.push_back(std::abs(error(later)));
      }
      t = next;
    }
  }
  double quantile(double q) {
    std::sort(errors.begin(), errors.end());
    return errors[static_cast<std::size_t>(q * static_cast<double>(errors.size() - 1))];
  }
};

}  // namespace palpate::inline time::testing
