#include "palpate/desktop/hit_sound.h"

#include <array>
#include <cmath>
#include <numbers>

namespace palpate::desktop {
namespace {

struct Tone {
  double hz, share, decay_s;
};
// The last one is the click that a hard impact adds.
constexpr std::array<Tone, 4> kHand{
    {{620.0, 0.62, 0.016}, {1130.0, 0.26, 0.010}, {1980.0, 0.08, 0.006}, {5200.0, 0.10, 0.002}}};
constexpr std::array<Tone, 4> kBody{
    {{1180.0, 0.60, 0.010}, {2240.0, 0.22, 0.006}, {3700.0, 0.08, 0.004}, {7100.0, 0.10, 0.0015}}};
constexpr double kAttack_s = 0.0006;     // from silence, so that it does not crack
constexpr double kRelease_s = 0.010;     // to silence
constexpr double kLoudest = 0.85;        // of full scale, all tones together
constexpr double kUsualImpulse = 0.012;  // N s: a ball of 2.7 g that turns round at 2.4 m/s

}  // namespace

double pitch_of(HitKind kind) { return kind == HitKind::hand ? kHand[0].hz : kBody[0].hz; }

std::vector<std::int16_t> hit_sound(HitKind kind, double impulse) {
  const auto count = static_cast<std::size_t>(kSoundLength_s * kSoundRate);
  std::vector<std::int16_t> samples(count, 0);
  if (!(impulse > 0.0) || !std::isfinite(impulse)) return samples;
  const double hardness = impulse / (impulse + kUsualImpulse);  // 0 to 1
  const double loudness = kLoudest * (kind == HitKind::hand ? 1.0 : 0.6) * std::sqrt(hardness) * 0.9;
  const auto& tones = kind == HitKind::hand ? kHand : kBody;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / kSoundRate;
    double sum = 0.0;
    for (std::size_t k = 0; k < tones.size(); ++k) {
      const double bright = k == 0 ? 1.0 : hardness;
      sum += bright * tones[k].share * std::exp(-t / tones[k].decay_s) *
             std::sin(2.0 * std::numbers::pi * tones[k].hz * t);
    }
    const double begin = t < kAttack_s ? 0.5 - 0.5 * std::cos(std::numbers::pi * t / kAttack_s) : 1.0;
    const double left = kSoundLength_s - t;
    const double end = left < kRelease_s ? left / kRelease_s : 1.0;
    samples[i] = static_cast<std::int16_t>(std::lround(32767.0 * loudness * begin * end * sum));
  }
  return samples;
}

}  // namespace palpate::desktop
