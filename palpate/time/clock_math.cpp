#include "palpate/time/clock_math.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace palpate::inline time::clock_math {
namespace {

constexpr double kFastestSlew = 500e-6;  // as NTP's: a haptic period is wrong by half a microsecond
constexpr double kSlewHorizonNs = 5e8;   // corrections are spread over this time where that is slow enough
constexpr double kDriftSd = 200e-6;      // crystal oscillators are sold with 20 to 100 ppm
constexpr double kDriftSdAfterSilence = 10e-6;  // minutes change the temperature, not the crystal
constexpr double kDriftWander = 1e-6;  // drift changes by about this much within the window (temperature)

double as_double(std::int64_t ns) { return static_cast<double>(ns); }
double square(double x) { return x * x; }
std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

}  // namespace

double Map::remaining_slew(std::int64_t t) const {
  return slew_error_ns * std::clamp(1.0 - as_double(t - from_ns) / slew_ns, 0.0, 1.0);
}

std::int64_t Map::forward(std::int64_t t) const {
  const std::int64_t d = t - from_ns;
  return to_ns + d + std::llround(drift * as_double(d) - remaining_slew(t));
}

std::int64_t Map::backward(std::int64_t t) const {
  // The slope is within 1e-3 of one, so the fixed point is reached to a nanosecond after a few rounds.
  std::int64_t from = from_ns + (t - to_ns);
  for (int i = 0; i < 8; ++i) {
    const std::int64_t miss = t - forward(from);
    if (miss == 0) break;
    from += miss;
  }
  return from;
}

double Map::uncertainty_at(std::int64_t t) const {
  return uncertainty_ns + std::abs(remaining_slew(t)) + drift_uncertainty * std::abs(as_double(t - from_ns));
}

Map slewed(const Map& published, Map wanted, std::int64_t now) {
  const double error = as_double(wanted.forward(now) - published.forward(now));
  wanted.slew_error_ns = error;
  wanted.slew_ns = std::max(kSlewHorizonNs, std::abs(error) / kFastestSlew);
  return wanted;
}

Point* Window::place(std::int64_t x) {
  const std::int64_t bucket = floor_div(x, kBucketNs);
  if (newest_ != kNone && bucket <= newest_ - kBuckets) return nullptr;
  newest_ = std::max(newest_, bucket);
  Point& p = points_[slot(bucket)];
  if (p.bucket != bucket) p = Point{.bucket = bucket};
  return &p;
}

void Window::clear() {
  points_.fill(Point{});
  newest_ = kNone;
}

void LineFit::add(double x, double z, double weight) {
  sw += weight;
  swx += weight * x;
  swxx += weight * x * x;
  swz += weight * z;
  swxz += weight * x * z;
}

void LineFit::solve(double prior_b, double prior_sd_b) {
  const double prior = 1.0 / square(prior_sd_b);
  const double xx = swxx + prior, xz = swxz + prior * prior_b;
  const double det = sw * xx - swx * swx;
  a = (swz * xx - xz * swx) / det;
  b = (sw * xz - swx * swz) / det;
  var_a = xx / det;
  var_b = sw / det;
  cov = -swx / det;
}

// --- one-way stamps

namespace {

constexpr double kJitterGuessNs = 100e3;  // spread of the delays before there are data to tell
constexpr double kJitterFloorNs = 1e3;    // stamps are no better than this
constexpr std::int64_t kEnvelopeStartNs = 2'000'000'000;
constexpr double kStartUncertaintyNs = 1e6;   // nothing is known yet about the device's jitter
constexpr std::int64_t kEarlyNs = 5'000'000;  // no sample can come this much before the quickest one
// Nothing arrives before it was taken: a sample that comes so much before its published time proves that all
// so far came late (a device, or this machine, that could not keep up as it began). What is proven wrong is
// begun anew, not slewed away at half a millisecond a second.
constexpr std::int64_t kProvenLateNs = 1'000'000;
constexpr std::int64_t kLateNs = 100'000'000;  // and none is this late for seconds on end
constexpr std::int64_t kLateForNs = 2'000'000'000;
constexpr std::int64_t kBackwardsNs = 1'000'000'000;  // a stamp that far back means a device clock set anew

}  // namespace

void Envelope::restart(std::int64_t stamp) {
  if (phase_ != Phase::empty) ++restarts_;
  window_.clear();
  phase_ = Phase::starting;
  first_ = newest_ = stamp;
  late_ = false;
}

bool Envelope::add(std::int64_t stamp, std::int64_t received, std::int64_t waited) {
  if (phase_ == Phase::empty || stamp < newest_ - kBackwardsNs) {
    restart(stamp);
  } else if (phase_ == Phase::tracking) {
    const std::int64_t lateness = received - fitted_.forward(stamp);
    if (lateness > kLateNs) {
      if (!late_) late_since_ = received;
      late_ = true;
    } else {
      late_ = false;
    }
    if (lateness < -kEarlyNs || (late_ && received - late_since_ > kLateForNs)) {
      restart(stamp);
    } else if (published_.forward(stamp) - received > kProvenLateNs) {
      restart(stamp);
      --restarts_;  // the device's clock is as it was
    }
  }
  Point* p = window_.place(stamp);
  if (p == nullptr) return false;
  newest_ = std::max(newest_, stamp);

  // The lowest of its half second, seen along the slope that is known so far.
  const std::int64_t z = received - stamp;
  const bool lowest = p->count == 0 || as_double(z - p->z) < fitted_.drift * as_double(stamp - p->x);
  ++p->count;
  if (!lowest) return true;
  p->x = stamp;
  p->z = z;
  p->delay = waited;
  refit(newest_);
  return true;
}

void Envelope::refit(std::int64_t now) {
  std::int64_t z_reference = 0;
  int most = 1, points = 0;
  window_.each([&](const Point& p) {
    z_reference = p.z;
    most = std::max(most, p.count);
    ++points;
  });
  // A half second whose best sample still came late lies above the line and counts less; nothing lies far
  // below.
  LineFit line;
  double sd = kJitterGuessNs, typical = kJitterGuessNs, waited = 0.0;
  for (int round = 0; round < 4; ++round) {
    LineFit next;
    window_.each([&](const Point& p) {
      const double x = as_double(p.x - now), z = as_double(p.z - z_reference);
      const double above = round == 0 ? 0.0 : std::max(0.0, z - line.a - line.b * x);
      const double weight = as_double(p.count) / most / (1.0 + square(above / (2.0 * typical)));
      next.add(x, z, weight / square(sd));
    });
    next.solve(0.0, kDriftSd);
    line = next;
    std::array<double, Window::kBuckets> residuals{};
    std::size_t n = 0;
    double sum = square(kJitterGuessNs), weights = 1.0;  // the guess counts as one more point
    waited = 0.0;
    window_.each([&](const Point& p) {
      const double r = as_double(p.z - z_reference) - line.a - line.b * as_double(p.x - now);
      residuals[n++] = std::abs(r);
      const double weight = as_double(p.count) / most / (1.0 + square(std::max(0.0, r) / (2.0 * typical)));
      sum += weight * square(r);
      weights += weight;
      waited += weight * as_double(p.delay);
    });
    waited /= weights - 1.0;
    const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(n / 2);
    std::nth_element(residuals.begin(), middle, residuals.begin() + static_cast<std::ptrdiff_t>(n));
    typical = std::max(kJitterFloorNs, *middle);
    sd = std::max(kJitterFloorNs, std::sqrt(sum / weights));
  }
  const bool starting = newest_ - first_ < kEnvelopeStartNs;
  fitted_ = Map{.from_ns = now,
                .to_ns = now + z_reference + std::llround(line.a),
                .drift = line.b,
                .uncertainty_ns =
                    3.0 * std::sqrt(line.var_a) + typical + waited + (starting ? kStartUncertaintyNs : 0.0),
                .drift_uncertainty = 3.0 * std::sqrt(line.var_b) + kDriftWander};
  published_ = phase_ == Phase::tracking ? slewed(published_, fitted_, now) : fitted_;
  if (!starting) phase_ = Phase::tracking;
}

// --- exchanges

namespace {

constexpr std::int64_t kExchangeStartNs = 1'000'000'000;
constexpr int kSeasoned = 8;             // points in the window that tell drift and shortest trip
constexpr double kStampSdNs = 3e3;       // clock reading and wake-up, of an exchange that met no delay
constexpr double kStepMarginNs = 100e3;  // wake-ups that hit one way only reach tens of microseconds
// The quickest trip may itself have been held up. By how much the others in the window tell, where none of them comes close
// to it; before there are enough of them, a part of the trip itself is assumed.
constexpr double kOfOthersDelay = 0.15, kOfShortestTrip = 0.05;

}  // namespace

bool Exchange::agree(const Sample& a, const Sample& b) const {
  return std::abs(as_double(a.z - b.z)) <
         0.5 * as_double(a.delay + b.delay) + kStepMarginNs + 2.0 * kDriftSd * std::abs(as_double(a.x - b.x));
}

void Exchange::begin(const Sample& s) {
  window_.clear();
  first_ = s.x;
  phase_ = Phase::starting;
  suspect_count_ = 0;
  unexplained_ = {};
}

Exchange::Result Exchange::add(std::int64_t t1, std::int64_t t2, std::int64_t t3, std::int64_t t4) {
  const Sample s{t1 + (t4 - t1) / 2, ((t2 - t1) + (t3 - t4)) / 2, (t4 - t1) - (t3 - t2)};
  // A peer's clock may drift a little while it holds the message; beyond that a negative trip is nonsense.
  if (t4 < t1 || t3 < t2 || s.delay < -1000) return Result::impossible;
  ++count_;
  if (phase_ == Phase::empty) {
    begin(s);
    take(s);
    return Result::used;
  }
  // What the fit leaves. Half of the difference to the lowest round trip may be delay: of this exchange, or
  // of all those before it if this is the quickest so far. Before a few seconds have shown how quick a trip
  // can be, only half of the whole trips is sure to explain it.
  const double least =
      points_ >= kSeasoned ? std::max(0.0, as_double(lowest_round_trip_) - shortest_held_up_) : 0.0;
  const double residual = as_double(s.x + s.z - fitted_.forward(s.x));
  const double explained = 0.5 * std::abs(as_double(s.delay) - least);
  const double statistical = std::max(0.0, fitted_.uncertainty_at(s.x) - 0.5 * least);
  if (std::abs(residual) > explained + statistical + kStepMarginNs) {
    if (suspect_count_ > 0 && !agree(s, suspects_[static_cast<std::size_t>(suspect_count_ - 1)]))
      suspect_count_ = 0;
    suspects_[static_cast<std::size_t>(suspect_count_++)] = s;
    if (suspect_count_ < 3) {
      if (phase_ == Phase::tracking) phase_ = Phase::doubtful;
      published_.uncertainty_ns =
          std::max(published_.uncertainty_ns, std::abs(residual) + 0.5 * as_double(s.delay));
      return Result::contradicts;
    }
    ++restarts_;
    begin(suspects_.front());
    for (const Sample& suspect : suspects_) take(suspect);
    return Result::restarted;
  }
  suspect_count_ = 0;
  if (phase_ == Phase::doubtful) phase_ = Phase::tracking;
  std::rotate(unexplained_.begin(), unexplained_.begin() + 1, unexplained_.end());
  unexplained_.back() = std::max(0.0, std::abs(residual) - explained);
  take(s);
  return Result::used;
}

void Exchange::take(const Sample& s) {
  Point* p = window_.place(s.x);
  if (p == nullptr) return;
  if (p->count == 0 || s.delay <= p->delay) {
    p->x = s.x;
    p->z = s.z;
    p->delay = s.delay;
  }
  ++p->count;
  refit(s.x + s.delay / 2);
}

double Exchange::shortest_held_up_ns(std::int64_t lowest) const {
  std::array<double, Window::kBuckets> longer{};
  std::size_t n = 0;
  window_.each([&](const Point& p) { longer[n++] = as_double(p.delay - lowest); });
  const auto middle = longer.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(longer.begin(), middle, longer.begin() + static_cast<std::ptrdiff_t>(n));
  const double missing = std::max(0.0, 1.0 - static_cast<double>(points_ - 1) / kSeasoned);
  return kOfOthersDelay * *middle + kOfShortestTrip * missing * std::max(0.0, as_double(lowest));
}

void Exchange::refit(std::int64_t now) {
  std::int64_t z_reference = 0, lowest = std::numeric_limits<std::int64_t>::max();
  points_ = 0;
  window_.each([&](const Point& p) {
    z_reference = p.z;
    lowest = std::min(lowest, p.delay);
    ++points_;
  });
  lowest_round_trip_ = std::max<std::int64_t>(0, lowest);
  shortest_held_up_ = shortest_held_up_ns(lowest);
  const auto variance = [&](const Point& p) {
    return square(kStampSdNs + 0.5 * (shortest_held_up_ + as_double(p.delay - lowest)));
  };
  LineFit line;
  window_.each([&](const Point& p) {
    line.add(as_double(p.x - now), as_double(p.z - z_reference), 1.0 / variance(p));
  });
  const bool silence = phase_ != Phase::starting && points_ < 4;
  line.solve(silence ? known_drift_ : 0.0, silence ? kDriftSdAfterSilence : kDriftSd);

  double chi2 = 0.0, half_trip = 0.0;
  window_.each([&](const Point& p) {
    const double r = as_double(p.z - z_reference) - line.a - line.b * as_double(p.x - now);
    chi2 += square(r) / variance(p);
    half_trip += 0.5 * as_double(p.delay) / variance(p);
  });
  const double inflate = std::sqrt(std::max(1.0, chi2 / std::max(1, points_ - 2)));
  const double unexplained = *std::min_element(unexplained_.begin(), unexplained_.end());
  fitted_ = Map{.from_ns = now,
                .to_ns = now + z_reference + std::llround(line.a),
                .drift = line.b,
                .uncertainty_ns = half_trip / line.sw + 3.0 * inflate * std::sqrt(line.var_a) + unexplained,
                .drift_uncertainty = 3.0 * inflate * std::sqrt(line.var_b) + kDriftWander};
  published_ = phase_ == Phase::starting ? fitted_ : slewed(published_, fitted_, now);
  if (phase_ == Phase::starting && now - first_ >= kExchangeStartNs) phase_ = Phase::tracking;
  if (points_ >= kSeasoned) known_drift_ = line.b;
}

}  // namespace palpate::inline time::clock_math
