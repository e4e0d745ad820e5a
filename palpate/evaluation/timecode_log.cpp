#include "palpate/evaluation/timecode_log.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::evaluation {
namespace {

constexpr Duration kKept = std::chrono::seconds(2);
constexpr Duration kShortest = std::chrono::microseconds(10);  // exposure; none at all has no mean

// A moment looks the same as the best one where the misfit speaks against it with less than three standard
// deviations of the bits' noise: what the best one leaves, or at least that of blocks of a hundred pixels.
constexpr double kSigmas = 3.0, kLeastNoise = 0.003;

double dot(const device::TimecodeBits& a, const device::TimecodeBits& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}
device::TimecodeBits minus(const device::TimecodeBits& a, const device::TimecodeBits& b) {
  device::TimecodeBits d{};
  for (std::size_t k = 0; k < a.size(); ++k) d[k] = a[k] - b[k];
  return d;
}

// A stretch of moments between two changes: off(x) = at 0 + x along, x in 0 ... 1.
struct Stretch {
  Instant<GraphicsClock> from, to;
  device::TimecodeBits off{}, along{};
  double best = 0.0, least = 0.0;  // x, and the squared misfit there

  Instant<GraphicsClock> at(double x) const {
    return from + Duration(std::llround(x * static_cast<double>((to - from).count())));
  }
  void solve() {
    const double slope = dot(along, along);
    best = slope > 0.0 ? std::clamp(-dot(off, along) / slope, 0.0, 1.0) : 0.5;
    least = misfit(best);
  }
  double misfit(double x) const {
    return dot(off, off) + 2.0 * x * dot(off, along) + x * x * dot(along, along);
  }
  // The part of it that is no worse than `most`; it has such a part.
  std::array<double, 2> within(double most) const {
    const double slope = dot(along, along);
    if (!(slope > 0.0)) return {0.0, 1.0};
    const double middle = -dot(off, along) / slope;
    const double half = std::sqrt(std::max(0.0, (most - misfit(middle)) / slope));
    return {std::clamp(middle - half, 0.0, 1.0), std::clamp(middle + half, 0.0, 1.0)};
  }
};

}  // namespace

void TimecodeLog::show(Instant<GraphicsClock> at, Duration code) {
  if (!shown_.empty() && at <= shown_.back().at) return;
  Shown next{.at = at};
  const device::TimecodeLight light = device::timecode_light(code, Duration(0));
  std::copy_n(light.begin() + 2, next.bits.size(), next.bits.begin());
  if (!shown_.empty()) {
    const auto& last = shown_.back();
    for (std::size_t k = 0; k < next.lit.size(); ++k)
      next.lit[k] = last.lit[k] + last.bits[k] * to_seconds(at - last.at);
  }
  shown_.push_back(next);
  while (at - shown_.front().at > kKept) shown_.pop_front();
}

// Goes forward through the log and knows how long each bit has been lit.
struct TimecodeLog::Cursor {
  const std::deque<Shown>& shown;
  std::size_t i = 0;
  device::TimecodeBits lit_until(Instant<GraphicsClock> t) {
    while (i + 1 < shown.size() && shown[i + 1].at <= t) ++i;
    device::TimecodeBits lit = shown[i].lit;
    for (std::size_t k = 0; k < lit.size(); ++k) lit[k] += shown[i].bits[k] * to_seconds(t - shown[i].at);
    return lit;
  }
};

Expected<TimecodeMoment> TimecodeLog::find(const device::TimecodeBits& seen, Duration exposure,
                                           Instant<GraphicsClock> latest) const {
  const Duration window = std::max(exposure, kShortest), half = window / 2;
  if (shown_.empty() || latest - shown_.front().at <= window)
    return refused("clock strip: nothing was shown yet when the image was taken");
  // Moments at which a change enters or leaves the exposure.
  const auto first = shown_.front().at + half, last = latest - half;
  std::vector<Instant<GraphicsClock>> turns{first};
  for (const auto& one : shown_)
    for (const auto t : {one.at - half, one.at + half})
      if (t > first && t < last) turns.push_back(t);
  turns.push_back(last);
  std::sort(turns.begin(), turns.end());

  Cursor begin{shown_}, end{shown_};
  const auto off = [&](Instant<GraphicsClock> middle) {
    const device::TimecodeBits from = begin.lit_until(middle - half), to = end.lit_until(middle + half);
    device::TimecodeBits mean = minus(to, from);
    for (auto& bit : mean) bit /= to_seconds(window);
    return minus(mean, seen);
  };
  std::vector<Stretch> stretches;
  device::TimecodeBits before = off(turns.front());
  std::size_t best = 0;
  for (std::size_t i = 1; i < turns.size(); ++i) {
    if (turns[i] == turns[i - 1]) continue;
    const device::TimecodeBits after = off(turns[i]);
    stretches.push_back({turns[i - 1], turns[i], before, minus(after, before)});
    stretches.back().solve();
    if (stretches.back().least < stretches[best].least) best = stretches.size() - 1;
    before = after;
  }
  TimecodeMoment moment;
  moment.residual = std::sqrt(stretches[best].least / device::kTimecodeBits);
  if (moment.residual > device::kMostTimecodeMisfit)
    return refused(
        "clock strip: at no moment of the last {:.0f} s it looked like this (off by {:.2f} of the contrast, "
        "at most {:.2f} is accepted); look whether something hides it, it is in focus, and the exposure is "
        "{:.1f} ms",
        to_seconds(latest - shown_.front().at), moment.residual, device::kMostTimecodeMisfit,
        1e3 * to_seconds(exposure));
  // All moments round the best that look the same.
  const double noise = std::max(std::sqrt(stretches[best].least / (device::kTimecodeBits - 1)), kLeastNoise);
  const double most = stretches[best].least + std::pow(kSigmas * noise, 2);
  auto low = stretches[best].at(stretches[best].within(most)[0]),
       high = stretches[best].at(stretches[best].within(most)[1]);
  for (std::size_t i = best; i > 0 && low == stretches[i].from && stretches[i - 1].misfit(1.0) <= most; --i)
    low = stretches[i - 1].at(stretches[i - 1].within(most)[0]);
  for (std::size_t i = best;
       i + 1 < stretches.size() && high == stretches[i].to && stretches[i + 1].misfit(0.0) <= most; ++i)
    high = stretches[i + 1].at(stretches[i + 1].within(most)[1]);
  moment.middle = low + (high - low) / 2;
  moment.unsure = (high - low) / 2;
  return moment;
}

}  // namespace palpate::evaluation
