#include "palpate/device/timecode.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::device {
namespace {

constexpr double kLeastContrast = 0.05;  // light of 0 ... 1
constexpr double kLeastBlock = 2.0;      // px
constexpr int kSamplesAcross = 5;        // of a block's middle half, each way

double in_ticks(Duration d) {
  return static_cast<double>(d.count()) / static_cast<double>(kTimecodeTick.count());
}
constexpr double kCycle = 1 << kTimecodeBits;  // ticks

// Time that bit k has been 1 from 0 to t (ticks). The bit is 1 in the middle half of its period, the highest
// bit, whose period is the cycle, in its second half.
double one_until(int k, double t) {
  const bool highest = k == kTimecodeBits - 1;
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
  const bool highest = k == kTimecodeBits - 1;
  const double period = highest ? kCycle : std::ldexp(4.0, k);
  const double phase = middle - std::floor(middle / period) * period;
  return highest ? (phase >= 0.5 * period ? 1.0 : 0.0)
                 : (phase >= 0.25 * period && phase < 0.75 * period ? 1.0 : 0.0);
}

double misfit(const TimecodeBits& bits, double middle, double exposure) {
  double sum = 0.0;
  for (int k = 0; k < kTimecodeBits; ++k) {
    const double off = bits[static_cast<std::size_t>(k)] - share(k, middle, exposure);
    sum += off * off;
  }
  return sum;
}

}  // namespace

TimecodeLight timecode_light(Duration middle, Duration exposure) {
  TimecodeLight light{};
  light[0] = light[kTimecodeBlocks - 1] = 1.0;
  for (int k = 0; k < kTimecodeBits; ++k)
    light[static_cast<std::size_t>(2 + k)] =
        exposure > Duration(0) ? share(k, in_ticks(middle % kTimecodeCycle), in_ticks(exposure))
                               : at(k, in_ticks(middle % kTimecodeCycle));
  return light;
}

double panel_light(double x, double y, const TimecodeLight& timecode) {
  const double inner = kPanelRim - 1.0;  // border without frame
  const auto within = [x, y](double rim) {
    return x >= rim && y >= rim && x < kPanelWide - rim && y < kPanelHigh - rim;
  };
  if (within(kPanelRim))
    return timecode[static_cast<std::size_t>(
        std::min(x - kPanelRim, static_cast<double>(kTimecodeBlocks - 1)))];
  return within(inner) && !within(inner + 0.5) ? 1.0 : 0.0;
}

Expected<TimecodeBits> timecode_bits(const TimecodeLight& blocks) {
  constexpr double kEnd = kTimecodeBlocks - 1;
  const double white = 0.5 * (blocks.front() + blocks.back());
  const double black = 0.5 * (blocks[1] + blocks[kTimecodeBlocks - 2]);
  if (!(white - black >= kLeastContrast))
    return refused(
        "clock strip: white and black differ by {:.2f} of full light, at least {:.2f} are needed; look "
        "whether it is in view and lit",
        white - black, kLeastContrast);
  TimecodeBits bits{};
  for (std::size_t k = 0; k < bits.size(); ++k) {
    const double i = static_cast<double>(k + 2);
    const double white_here = blocks.front() + (blocks.back() - blocks.front()) * i / kEnd;
    const double black_here =
        blocks[1] + (blocks[kTimecodeBlocks - 2] - blocks[1]) * (i - 1.0) / (kEnd - 2.0);
    bits[k] = (blocks[k + 2] - black_here) / std::max(white_here - black_here, kLeastContrast);
  }
  return bits;
}

Expected<TimecodeReading> read_timecode(const TimecodeLight& blocks, Duration exposure) {
  const auto seen = timecode_bits(blocks);
  if (!seen) return tl::unexpected(seen.error());
  const TimecodeBits& bits = *seen;
  const double window = in_ticks(exposure);
  // Every half tick, and finer round the best: between two changes of a bit the blocks are linear in time.
  double best = 0.0, least = std::numeric_limits<double>::infinity();
  for (double t = 0.0; t < kCycle; t += 0.5)
    if (const double m = misfit(bits, t, window); m < least) least = m, best = t;
  for (double step = 0.25; step > 1e-4; step *= 0.5)
    for (const double t : {best - step, best + step})
      if (const double m = misfit(bits, t, window); m < least) least = m, best = t;
  TimecodeReading reading;
  reading.residual = std::sqrt(least / kTimecodeBits);
  if (reading.residual > kMostTimecodeMisfit)
    return refused(
        "clock strip: no moment has blocks like these (off by {:.2f} of the contrast, at most {:.2f} is "
        "accepted); look whether something hides it, it is in focus, and the exposure is {:.1f} ms",
        reading.residual, kMostTimecodeMisfit, window);
  const double turned = best - std::floor(best / kCycle) * kCycle;
  reading.middle =
      Duration(std::llround(turned * static_cast<double>(kTimecodeTick.count()))) % kTimecodeCycle;
  return reading;
}

Matrix3 from_unit_square(const std::array<Pixel, 4>& c) {
  const Pixel sum = c[0] - c[1] + c[2] - c[3], a = c[1] - c[2], b = c[3] - c[2];
  const double det = a.x() * b.y() - b.x() * a.y();
  const double g = (sum.x() * b.y() - b.x() * sum.y()) / det, h = (a.x() * sum.y() - sum.x() * a.y()) / det;
  Matrix3 H;
  H << c[1].x() - c[0].x() + g * c[1].x(), c[3].x() - c[0].x() + h * c[3].x(), c[0].x(),
      c[1].y() - c[0].y() + g * c[1].y(), c[3].y() - c[0].y() + h * c[3].y(), c[0].y(), g, h, 1.0;
  return H;
}

namespace {

// Of the middle of each block, between two heights in blocks from the timecode's upper edge.
TimecodeLight mean_light(std::span<const std::uint8_t> rgb, int width, int height,
                         const std::array<Pixel, 4>& corners, double from, double to) {
  const auto pixel = [&](int x, int y) {
    const std::uint8_t* value =
        rgb.data() +
        3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
    double sum = 0.0;
    for (int c = 0; c < 3; ++c) sum += value[c] * value[c];
    return sum / (3.0 * 255.0 * 255.0);
  };
  const auto light = [&](const Pixel& p) {
    const int u = std::clamp(static_cast<int>(p.x()), 0, width - 2),
              v = std::clamp(static_cast<int>(p.y()), 0, height - 2);
    const double s = std::clamp(p.x() - u, 0.0, 1.0), t = std::clamp(p.y() - v, 0.0, 1.0);
    return (1 - t) * ((1 - s) * pixel(u, v) + s * pixel(u + 1, v)) +
           t * ((1 - s) * pixel(u, v + 1) + s * pixel(u + 1, v + 1));
  };
  const Matrix3 to_picture = from_unit_square(corners);
  TimecodeLight blocks{};
  for (int i = 0; i < kTimecodeBlocks; ++i) {
    double sum = 0.0;
    for (int a = 0; a < kSamplesAcross; ++a)
      for (int b = 0; b < kSamplesAcross; ++b) {
        const double x = (i + 0.3 + 0.4 * (a + 0.5) / kSamplesAcross) / kTimecodeBlocks;
        const double y = from + (to - from) * (b + 0.5) / kSamplesAcross;
        sum += light((to_picture * Vector3(x, y, 1.0)).hnormalized());
      }
    blocks[static_cast<std::size_t>(i)] = sum / (kSamplesAcross * kSamplesAcross);
  }
  return blocks;
}

}  // namespace

Expected<TimecodeLight> timecode_blocks(std::span<const std::uint8_t> rgb, int width, int height,
                                        const std::array<Pixel, 4>& corners) {
  for (const auto& corner : corners)
    if (!(corner.x() >= 0 && corner.y() >= 0 && corner.x() <= width - 1 && corner.y() <= height - 1))
      return refused("clock strip: its corner at {:.0f}, {:.0f} px lies outside the picture of {} x {}",
                     corner.x(), corner.y(), width, height);
  const double wide =
      std::min((corners[1] - corners[0]).norm(), (corners[2] - corners[3]).norm()) / kTimecodeBlocks;
  const double high = std::min((corners[3] - corners[0]).norm(), (corners[2] - corners[1]).norm());
  if (!(std::min(wide, high) >= kLeastBlock))
    return refused(
        "clock strip: its blocks are {:.1f} x {:.1f} px, at least {:.0f} are needed; bring it nearer", wide,
        high, kLeastBlock);
  return mean_light(rgb, width, height, corners, 0.25, 0.75);
}

Expected<TimecodeLight> panel_blocks(std::span<const std::uint8_t> rgb, int width, int height,
                                     const std::array<Pixel, 4>& corners) {
  auto blocks = timecode_blocks(rgb, width, height, corners);
  if (!blocks) return blocks;
  // The frame's middle is three quarters of a block beyond the timecode's edge.
  const TimecodeLight above = mean_light(rgb, width, height, corners, -0.85, -0.65),
                      below = mean_light(rgb, width, height, corners, 1.65, 1.85);
  TimecodeLight frame{};
  double mean = 0.0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    frame[i] = 0.5 * (above[i] + below[i]);
    mean += frame[i] / kTimecodeBlocks;
  }
  for (std::size_t i = 0; i < frame.size(); ++i) (*blocks)[i] *= mean / std::max(frame[i], kLeastContrast);
  return blocks;
}

void draw_panel(std::vector<std::uint8_t>& rgb, int width, int height, int left, int top, int block,
                Duration now) {
  const TimecodeLight light = timecode_light(now, Duration(0));
  const int wide = static_cast<int>(kPanelWide * block), high = static_cast<int>(kPanelHigh * block);
  for (int v = std::max(0, top); v < std::min(height, top + high); ++v)
    for (int u = std::max(0, left); u < std::min(width, left + wide); ++u) {
      const double value = panel_light((u - left + 0.5) / block, (v - top + 0.5) / block, light);
      const auto byte = static_cast<std::uint8_t>(std::lround(255.0 * std::sqrt(value)));
      std::uint8_t* pixel = rgb.data() + 3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                                              static_cast<std::size_t>(u));
      pixel[0] = pixel[1] = pixel[2] = byte;
    }
}

Duration timecode_difference(Duration a, Duration b) {
  Duration d = (b - a) % kTimecodeCycle;
  if (d > kTimecodeCycle / 2) d -= kTimecodeCycle;
  if (d < -kTimecodeCycle / 2) d += kTimecodeCycle;
  return d;
}

}  // namespace palpate::device
