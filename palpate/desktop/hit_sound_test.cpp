#include "palpate/desktop/hit_sound.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace palpate::desktop {
namespace {

double energy(const std::vector<std::int16_t>& samples, double from_s = 0.0, double to_s = 1.0) {
  double sum = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double t = static_cast<double>(i) / kSoundRate;
    if (t >= from_s && t < to_s) sum += static_cast<double>(samples[i]) * samples[i];
  }
  return sum;
}

// One bin of the Fourier transform.
double strength(const std::vector<std::int16_t>& samples, double hz) {
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i)
    sum += static_cast<double>(samples[i]) *
           std::polar(1.0, -2.0 * std::numbers::pi * hz * static_cast<double>(i) / kSoundRate);
  return std::abs(sum);
}

int loudest(const std::vector<std::int16_t>& samples) {
  int most = 0;
  for (const auto s : samples) most = std::max(most, std::abs(static_cast<int>(s)));
  return most;
}

class EveryHit : public testing::TestWithParam<HitKind> {};
INSTANTIATE_TEST_SUITE_P(HitSound, EveryHit, testing::Values(HitKind::hand, HitKind::body));

TEST_P(EveryHit, IsLouderTheHarderItIsAndNeverBeyondFullScale) {
  int before = 0;
  for (const double impulse : {0.0005, 0.002, 0.008, 0.03, 0.1, 10.0}) {
    const int now = loudest(hit_sound(GetParam(), impulse));
    EXPECT_GT(now, before) << impulse;
    EXPECT_LT(now, 32767) << impulse;
    before = now;
  }
  EXPECT_GT(before, 6000);  // a very hard one is well heard
}

TEST_P(EveryHit, BeginsAndEndsInSilence) {
  const auto samples = hit_sound(GetParam(), 0.02);
  EXPECT_EQ(samples.front(), 0);
  // 40 dB below its loudest at the last sample: no crack.
  EXPECT_LT(std::abs(static_cast<int>(samples.back())), loudest(samples) / 100 + 1);
  // Short: a millionth of the energy is left after 0.1 s.
  EXPECT_LT(energy(samples, 0.1), 1e-5 * energy(samples));
}

TEST_P(EveryHit, RingsAtItsPitch) {
  const auto samples = hit_sound(GetParam(), 0.02);
  double best = 0.0, at = 0.0;
  for (double hz = 100.0; hz < 10000.0; hz += 20.0)
    if (const double s = strength(samples, hz); s > best) best = s, at = hz;
  EXPECT_NEAR(at, pitch_of(GetParam()), 40.0);  // a damped tone is that wide
}

TEST_P(EveryHit, IsBrighterTheHarderItIs) {
  const auto brightness = [&](double impulse) {
    const auto samples = hit_sound(GetParam(), impulse);
    return strength(samples, 2.0 * pitch_of(GetParam())) / strength(samples, pitch_of(GetParam()));
  };
  EXPECT_GT(brightness(0.05), 1.2 * brightness(0.002));
}

TEST_P(EveryHit, IsSilenceWithoutAnImpulseOrWithOneThatIsNoNumber) {
  for (const double none : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_EQ(loudest(hit_sound(GetParam(), none)), 0);
}

TEST(HitSound, TellsBatFromTable) { EXPECT_GT(pitch_of(HitKind::body), 1.5 * pitch_of(HitKind::hand)); }

}  // namespace
}  // namespace palpate::desktop
