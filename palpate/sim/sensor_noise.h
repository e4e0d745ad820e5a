// Noise of a camera sensor: independent Gaussian grey levels, the same for the same seed.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace palpate::sim {

class SensorNoise {
 public:
  // Standard deviation in grey levels of 255; below 30.
  explicit SensorNoise(double sd);
  double sd() const { return sd_; }
  // Adds noise to each byte, clamped to 0..255. Integer arithmetic on a counter's hash (splitmix64): the same
  // bytes on every machine.
  void add(std::span<std::uint8_t> pixels, std::uint64_t seed) const;

 private:
  double sd_;
  std::array<std::int8_t, 4096> quantiles_{};  // of the normal distribution, in grey levels
};

}  // namespace palpate::sim
