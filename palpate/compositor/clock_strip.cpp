#include "palpate/compositor/clock_strip.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

constexpr double kLeastContrast = 0.05;  // light of 0 ... 1
constexpr double kMostMisfit = 0.12;     // rms, share of the contrast; what half a block's mix-up leaves
constexpr double kLeastBlock = 2.0;      // px
constexpr int kSamplesAcross = 5;        // of a block's middle half, each way

double in_ticks(Duration d) {
  return static_cast<double>(d.count()) / static_cast<double>(kStripTick.count());
}
constexpr double kCycle = 1 << kStripBits;  // ticks

// Time that bit k has been 1 from 0 to t (ticks). The bit is 1 in the middle half of its period, the highest
// bit, whose period is the cycle, in its second half.
double one_until(int k, double t) {
  const bool highest = k == kStripBits - 1;
  const double period = highest ? kCycle : std::ldexp(4.0, k);
  const double begin = highest ? 0.5 * period : 0.25 * period, length = 0.5 * period;
  const double whole = std::floor(t / period);
  return whole * length + std::clamp(t - whole * period - begin, 0.0, length);
}

double share(int k, double middle, double exposure) {
  // No exposure: a moment so short that no bit changes within it.
  const double window = std::max(exposure, 1e-9), from = middle - 0.5 * window;
  return (one_until(k, from + window) - one_until(k, from)) / window;
}

double at(int k, double middle) {  // without an exposure, exactly 0 or 1
  const bool highest = k == kStripBits - 1;
  const double period = highest ? kCycle : std::ldexp(4.0, k);
  const double phase = middle - std::floor(middle / period) * period;
  return highest ? (phase >= 0.5 * period ? 1.0 : 0.0)
                 : (phase >= 0.25 * period && phase < 0.75 * period ? 1.0 : 0.0);
}

using Bits = std::array<double, kStripBits>;

double misfit(const Bits& bits, double middle, double exposure) {
  double sum = 0.0;
  for (int k = 0; k < kStripBits; ++k) {
    const double off = bits[static_cast<std::size_t>(k)] - share(k, middle, exposure);
    sum += off * off;
  }
  return sum;
}

}  // namespace

StripLight strip_light(Duration middle, Duration exposure) {
  StripLight light{};
  light[0] = light[kStripBlocks - 1] = 1.0;
  for (int k = 0; k < kStripBits; ++k)
    light[static_cast<std::size_t>(2 + k)] =
        exposure > Duration(0) ? share(k, in_ticks(middle % kStripCycle), in_ticks(exposure))
                               : at(k, in_ticks(middle % kStripCycle));
  return light;
}

Expected<StripReading> read_strip(const StripLight& blocks, Duration exposure) {
  const double white = 0.5 * (blocks.front() + blocks.back());
  const double black = 0.5 * (blocks[1] + blocks[kStripBlocks - 2]), contrast = white - black;
  if (!(contrast >= kLeastContrast))
    return refused(
        "clock strip: white and black differ by {:.2f} of full light, at least {:.2f} are needed; look "
        "whether "
        "it is in view and lit",
        contrast, kLeastContrast);
  Bits bits{};
  for (std::size_t k = 0; k < bits.size(); ++k) bits[k] = (blocks[2 + k] - black) / contrast;
  const double window = in_ticks(exposure);
  // Every half tick, and finer round the best: between two changes of a bit the blocks are linear in time.
  double best = 0.0, least = std::numeric_limits<double>::infinity();
  for (double t = 0.0; t < kCycle; t += 0.5)
    if (const double m = misfit(bits, t, window); m < least) least = m, best = t;
  for (double step = 0.25; step > 1e-4; step *= 0.5)
    for (const double t : {best - step, best + step})
      if (const double m = misfit(bits, t, window); m < least) least = m, best = t;
  StripReading reading;
  reading.residual = std::sqrt(least / kStripBits);
  if (reading.residual > kMostMisfit)
    return refused(
        "clock strip: no moment has blocks like these (off by {:.2f} of the contrast, at most {:.2f} is "
        "accepted); look whether something hides it, it is in focus, and the exposure is {:.1f} ms",
        reading.residual, kMostMisfit, window);
  const double turned = best - std::floor(best / kCycle) * kCycle;
  reading.middle = Duration(std::llround(turned * static_cast<double>(kStripTick.count()))) % kStripCycle;
  return reading;
}

Expected<StripLight> strip_blocks(std::span<const std::uint8_t> rgb, int width, int height,
                                  const std::array<Pixel, 4>& corners) {
  for (const auto& corner : corners)
    if (!(corner.x() >= 0 && corner.y() >= 0 && corner.x() <= width - 1 && corner.y() <= height - 1))
      return refused("clock strip: its corner at {:.0f}, {:.0f} px lies outside the picture of {} x {}",
                     corner.x(), corner.y(), width, height);
  const double wide =
      std::min((corners[1] - corners[0]).norm(), (corners[2] - corners[3]).norm()) / kStripBlocks;
  const double high = std::min((corners[3] - corners[0]).norm(), (corners[2] - corners[1]).norm());
  if (!(std::min(wide, high) >= kLeastBlock))
    return refused(
        "clock strip: its blocks are {:.1f} x {:.1f} px, at least {:.0f} are needed; bring it nearer", wide,
        high, kLeastBlock);
  const auto light = [&](const Pixel& p) {
    const int u = std::min(static_cast<int>(p.x()), width - 2),
              v = std::min(static_cast<int>(p.y()), height - 2);
    const double s = p.x() - u, t = p.y() - v;
    const auto pixel = [&](int x, int y) {
      const std::uint8_t* value =
          rgb.data() +
          3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
      double sum = 0.0;
      for (int c = 0; c < 3; ++c) sum += value[c] * value[c];
      return sum / (3.0 * 255.0 * 255.0);
    };
    return (1 - t) * ((1 - s) * pixel(u, v) + s * pixel(u + 1, v)) +
           t * ((1 - s) * pixel(u, v + 1) + s * pixel(u + 1, v + 1));
  };
  StripLight blocks{};
  for (int i = 0; i < kStripBlocks; ++i) {
    double sum = 0.0;
    for (int a = 0; a < kSamplesAcross; ++a)
      for (int b = 0; b < kSamplesAcross; ++b) {
        const double x = (i + 0.25 + 0.5 * (a + 0.5) / kSamplesAcross) / kStripBlocks;
        const double y = 0.25 + 0.5 * (b + 0.5) / kSamplesAcross;
        sum += light((1 - y) * ((1 - x) * corners[0] + x * corners[1]) +
                     y * ((1 - x) * corners[3] + x * corners[2]));
      }
    blocks[static_cast<std::size_t>(i)] = sum / (kSamplesAcross * kSamplesAcross);
  }
  return blocks;
}

void draw_strip(std::vector<std::uint8_t>& rgb, int width, int height, int left, int top, int block,
                Duration now) {
  const StripLight light = strip_light(now, Duration(0));
  const int margin = block / 2;
  for (int v = std::max(0, top - margin); v < std::min(height, top + block + margin); ++v)
    for (int u = std::max(0, left - margin); u < std::min(width, left + kStripBlocks * block + margin); ++u) {
      const bool inside = v >= top && v < top + block && u >= left && u < left + kStripBlocks * block;
      const double value = inside ? light[static_cast<std::size_t>((u - left) / block)] : 0.0;
      const auto byte = static_cast<std::uint8_t>(std::lround(255.0 * std::sqrt(value)));
      std::uint8_t* pixel = rgb.data() + 3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                                              static_cast<std::size_t>(u));
      pixel[0] = pixel[1] = pixel[2] = byte;
    }
}

Duration strip_difference(Duration a, Duration b) {
  Duration d = (b - a) % kStripCycle;
  if (d > kStripCycle / 2) d -= kStripCycle;
  if (d < -kStripCycle / 2) d += kStripCycle;
  return d;
}

}  // namespace palpate
