// A fixed, smooth random scalar field in space: the systematic, place-dependent part of a measurement's
// error.
//
// Mean 0, standard deviation 1 over draws of the field, correlation exp(-|d|^2 / 2 L^2) between places d
// apart. Method: random Fourier features (Rahimi & Recht 2007): sum of cosines whose wave vectors are normal
// with sd 1/L. Metres. Immutable after construction, safe from any thread.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "palpate/core/random.h"
#include "palpate/math/so3.h"

namespace palpate::sim {

class SmoothField {
 public:
  SmoothField(std::uint64_t seed, std::string_view purpose, double correlation_length) {
    Random random(seed, purpose);
    for (auto& wave : waves_) {
      // One after the other: a call's arguments are drawn in an order that is the compiler's.
      const double z = random.normal(), y = random.normal(), x = random.normal();
      wave.k = Vector3(x, y, z) / correlation_length;
      wave.phase = random.uniform(0.0, 2.0 * std::numbers::pi);
    }
  }

  double at(const Vector3& place) const {
    double sum = 0.0;
    for (const auto& wave : waves_) sum += std::cos(wave.k.dot(place) + wave.phase);
    return std::sqrt(2.0 / kWaves) * sum;
  }

 private:
  static constexpr int kWaves = 24;  // enough for a near-normal value at each place; cost grows with it
  struct Wave {
    Vector3 k = Vector3::Zero();
    double phase = 0.0;
  };
  std::array<Wave, kWaves> waves_;
};

}  // namespace palpate::sim
