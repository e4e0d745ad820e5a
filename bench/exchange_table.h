// What a run of the exchange bench is paced by, and the table it prints.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "palpate/core/statistics.h"
#include "palpate/time/clock.h"

namespace palpate::exchange_bench {

using Times = std::vector<double>;  // us

inline void require(bool condition, const std::string& what) {
  if (!condition) throw std::runtime_error(what);
}

struct Pace {
  Duration period;
  std::int64_t next = MonotonicClock<GraphicsClock>::monotonic_ns();
  void wait() {
    next += period.count();
    MonotonicClock<GraphicsClock>().sleep_until({Duration(next)});
  }
};

struct Load {
  double rate_hz = 100.0;
  int requests = 100;  // per leg
  std::size_t reply_bytes = 0;
  bool shape = false;
  Duration period() const { return seconds(1.0 / rate_hz); }
};

inline double p99(const Times& values) { return quantile(values, 0.99); }

struct Row {
  std::string name;
  Times medians, p99s, all;  // ratios round by round; us
  double bar = 0.0;          // of the median's ratio; 0: none
};

inline void print(const Row& row, double p99_bar) {
  std::string verdict;
  if (row.bar > 0.0) {
    const bool holds = median(row.medians) <= row.bar && median(row.p99s) <= p99_bar;
    verdict = fmt::format("  bar {:.1f}, p99 {:.1f}: {}", row.bar, p99_bar, holds ? "holds" : "MISSED");
  }
  fmt::print("  {:<16} {:6.0f} us  ratio {:.2f} ({:.2f} to {:.2f})   p99 {:6.0f} us  ratio {:.2f}{}\n",
             row.name, median(row.all), median(row.medians), quantile(row.medians, 0.0),
             quantile(row.medians, 1.0), p99(row.all), median(row.p99s), verdict);
}

}  // namespace palpate::exchange_bench
