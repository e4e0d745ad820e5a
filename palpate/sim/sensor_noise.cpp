#include "palpate/sim/sensor_noise.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace palpate::sim {
namespace {

std::uint64_t hash(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

// z with P(Z < z) = p, p <= 1/2, by halving.
double lower_quantile(double p) {
  double low = -9.0, high = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

SensorNoise::SensorNoise(double sd) : sd_(sd) {
  if (!(sd >= 0.0 && sd < 30.0))
    throw std::invalid_argument("sensor noise: sd must lie in 0 ... 30 grey levels");
  const std::size_t half = quantiles_.size() / 2;
  for (std::size_t i = 0; i < half; ++i) {
    const double z = lower_quantile((static_cast<double>(i) + 0.5) / static_cast<double>(quantiles_.size()));
    quantiles_[i] = static_cast<std::int8_t>(std::lround(sd * z));
    quantiles_[quantiles_.size() - 1 - i] = static_cast<std::int8_t>(-quantiles_[i]);
  }
}

void SensorNoise::add(std::span<std::uint8_t> pixels, std::uint64_t seed) const {
  if (sd_ == 0.0) return;
  const std::uint64_t stream = hash(seed);
  for (std::size_t i = 0; i < pixels.size(); i += 5) {
    std::uint64_t bits = hash(stream + i);
    const std::size_t end = std::min(i + 5, pixels.size());
    for (std::size_t k = i; k < end; ++k, bits >>= 12) {
      pixels[k] = static_cast<std::uint8_t>(std::clamp(pixels[k] + quantiles_[bits & 4095u], 0, 255));
    }
  }
}

}  // namespace palpate::sim
