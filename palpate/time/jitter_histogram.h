// Counts durations so that their quantiles can be read while a loop adds to
// them.
//
// Sixteen bins per octave from 16 ns to 18 minutes: a quantile is right to 1/16
// of its value. One thread adds, any thread reads; nothing locks or allocates.
// A reader that looks while one is being added may miss that one.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "palpate/time/instant.h"

namespace palpate::inline time {

class JitterHistogram {
 public:
  // Negative durations count as zero.
  void add(Duration d) noexcept {
    const std::uint64_t ns = static_cast<std::uint64_t>(std::max<std::int64_t>(0, d.count()));
    std::atomic<std::uint64_t>& bin = bins_[bin_of(ns)];
    bin.store(bin.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (ns > max_.load(std::memory_order_relaxed)) max_.store(ns, std::memory_order_relaxed);
  }

  std::uint64_t count() const noexcept {
    std::uint64_t sum = 0;
    for (const auto& bin : bins_) sum += bin.load(std::memory_order_relaxed);
    return sum;
  }
  Duration max() const noexcept {
    return Duration(static_cast<std::int64_t>(max_.load(std::memory_order_relaxed)));
  }

  // The upper edge of the bin that holds the quantile q in [0, 1], at most
  // max(); zero where nothing was added.
  Duration quantile(double q) const noexcept {
    const std::uint64_t n = count();
    const auto rank = static_cast<std::uint64_t>(q * static_cast<double>(n));
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < kBins; ++i) {
      below += bins_[i].load(std::memory_order_relaxed);
      if (below > rank || (n > 0 && below == n)) return std::min(max(), Duration(upper_edge(i)));
    }
    return Duration(0);
  }

  // Counts below 16 ns, 32 ns, 64 ns, ...: each octave up to the next one's edge.
  static constexpr std::size_t kOctaves = 37;
  std::array<std::uint64_t, kOctaves> octaves() const noexcept {
    std::array<std::uint64_t, kOctaves> counts{};
    for (std::size_t i = 0; i < kBins; ++i) counts[i / 16] += bins_[i].load(std::memory_order_relaxed);
    return counts;
  }

  // Counts of half octaves: i stands for durations from half_octave_ns(i) up to half_octave_ns(i + 1).
  static constexpr std::size_t kHalfOctaves = 2 * kOctaves;
  std::array<std::uint64_t, kHalfOctaves> half_octaves() const noexcept {
    std::array<std::uint64_t, kHalfOctaves> counts{};
    for (std::size_t i = 0; i < kBins; ++i) counts[i / 8] += bins_[i].load(std::memory_order_relaxed);
    return counts;
  }
  // 0, 8, 16, 24, 32, 48, 64, ...
  static constexpr std::uint64_t half_octave_ns(std::size_t i) {
    return i < 4 ? 8 * i : (2 + i % 2) << (i / 2 + 2);
  }

 private:
  static constexpr std::size_t kBins = 16 * kOctaves;

  static std::size_t bin_of(std::uint64_t ns) {
    if (ns < 16) return static_cast<std::size_t>(ns);
    const unsigned shift = static_cast<unsigned>(std::bit_width(ns)) - 5;
    return std::min<std::size_t>(kBins - 1, 16 * (shift + 1) + static_cast<std::size_t>((ns >> shift) - 16));
  }
  static std::int64_t upper_edge(std::size_t bin) {
    if (bin < 16) return static_cast<std::int64_t>(bin);
    const std::size_t shift = bin / 16 - 1;
    return (static_cast<std::int64_t>(bin % 16 + 17) << shift) - 1;
  }

  std::array<std::atomic<std::uint64_t>, kBins> bins_{};
  std::atomic<std::uint64_t> max_{0};
};

}  // namespace palpate::inline time
