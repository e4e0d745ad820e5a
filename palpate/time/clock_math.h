// The arithmetic behind ClockModel, ClockEstimator and ClockSync, on bare nanoseconds: nothing here knows
// which clock is which, so nothing outside palpate/time uses it.
//
// Times are integer nanoseconds, differences of times are exact; drift is dimensionless (1e-6 = 1 ppm). Each
// object belongs to one thread. Nothing allocates.
//
// Sources. Offset and round trip of an exchange: Mills, RFC 5905 (2010), section 8. Delay only ever adds, so
// a line under the cloud of one-way delays gives offset and drift: Moon, Skelly & Towsley, "Estimation and
// removal of clock skew from network delay measurements", INFOCOM 1999. Equations and limits:
// docs/theory/clocks.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace palpate::inline time::clock_math {

// to = to_ns + (1 + drift)(t - from_ns) - slew_error (1 - (t - from_ns) / slew_ns)+ : an affine map, minus a
// remainder that was not allowed to jump and dies away linearly over slew_ns. Constant before from_ns.
struct Map {
  std::int64_t from_ns = 0, to_ns = 0;
  double drift = 0.0;
  double slew_error_ns = 0.0, slew_ns = 1.0;
  double uncertainty_ns = 0.0,
         drift_uncertainty = 0.0;  // at from_ns, and its growth per second away from there

  std::int64_t forward(std::int64_t t) const;
  std::int64_t backward(std::int64_t t) const;
  double uncertainty_at(std::int64_t t) const;
  double remaining_slew(std::int64_t t) const;
};

// Keeps `wanted` from jumping: the result agrees with `published` at now and with `wanted` once the remainder
// has died away, which takes half a second or as long as the fastest allowed slew needs. Both maps are
// anchored at now.
Map slewed(const Map& published, Map wanted, std::int64_t now);

// What the estimators remember: the best point of each half second, over the last twelve seconds.
struct Point {
  std::int64_t bucket = std::numeric_limits<std::int64_t>::min();
  std::int64_t x = 0, z = 0;  // ns: time, and the other clock's lead at that time
  std::int64_t delay = 0;     // ns: round trip of an exchange; how long a stamp may have lain unread
  int count = 0;              // how many samples the point was chosen from
};

class Window {
 public:
  static constexpr int kBuckets = 24;
  static constexpr std::int64_t kBucketNs = 500'000'000;

  // The place of the point for time x, emptied if it belongs to an earlier round; null for what is too old.
  Point* place(std::int64_t x);
  // Calls f(point) for every point that is still in the window, oldest first.
  template <typename F>
  void each(F f) const {
    if (newest_ == kNone) return;
    for (std::int64_t b = newest_ - kBuckets + 1; b <= newest_; ++b) {
      const Point& p = points_[slot(b)];
      if (p.bucket == b && p.count > 0) f(p);
    }
  }
  void clear();

 private:
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::min();
  static std::size_t slot(std::int64_t bucket) {
    return static_cast<std::size_t>(((bucket % kBuckets) + kBuckets) % kBuckets);
  }
  std::array<Point, kBuckets> points_{};
  std::int64_t newest_ = kNone;
};

// z = a + b x by weighted least squares with a normal prior on b; covariance for weights that are 1 /
// variance.
struct LineFit {
  double sw = 0, swx = 0, swxx = 0, swz = 0, swxz = 0;  // x and z relative to a reference near them
  double a = 0, b = 0, var_a = 0, var_b = 0, cov = 0;
  void add(double x, double z, double weight);
  void solve(double prior_b, double prior_sd_b);
};

enum class Phase : std::uint8_t {
  empty,     // nothing heard yet
  starting,  // first second or two: the published map may still step
  tracking,  // slews only
  doubtful,  // the newest exchanges contradict the model: the uncertainty says by how much
};

// One-way stamps: received = map(stamp) + delay, delay >= 0, of which up to `waited` is the receiver's doing.
class Envelope {
 public:
  // False: the stamp is older than the window and was not used.
  bool add(std::int64_t stamp, std::int64_t received, std::int64_t waited);
  const Map& map() const { return published_; }
  Phase phase() const { return phase_; }
  int restarts() const { return restarts_; }

 private:
  void restart(std::int64_t stamp);
  void refit(std::int64_t now);

  Window window_;
  Map fitted_, published_;
  Phase phase_ = Phase::empty;
  std::int64_t first_ = 0, newest_ = 0, late_since_ = 0;
  bool late_ = false;
  int restarts_ = 0;
};

// Four time stamps: t1 local send, t2 remote receive, t3 remote send, t4 local receive. The map leads from
// local to remote time.
class Exchange {
 public:
  enum class Result : std::uint8_t { used, impossible, contradicts, restarted };
  Result add(std::int64_t t1, std::int64_t t2, std::int64_t t3, std::int64_t t4);
  const Map& map() const { return published_; }
  Phase phase() const { return phase_; }
  int restarts() const { return restarts_; }
  int count() const { return count_; }
  std::int64_t lowest_round_trip_ns() const { return lowest_round_trip_; }

 private:
  struct Sample {
    std::int64_t x = 0, z = 0, delay = 0;
  };
  void take(const Sample& s);
  void begin(const Sample& s);
  void refit(std::int64_t now);
  bool agree(const Sample& a, const Sample& b) const;
  double shortest_held_up_ns(std::int64_t lowest) const;

  Window window_;
  Map fitted_, published_;
  Phase phase_ = Phase::empty;
  std::int64_t first_ = 0, lowest_round_trip_ = 0;
  double shortest_held_up_ = 0.0;  // ns: by how much the lowest round trip may be longer than it need be
  double known_drift_ = 0.0;  // from the last well filled window; what is left to go by after a long silence
  std::array<double, 3> unexplained_{};  // what the last residuals keep when their extra delay is taken off
  std::array<Sample, 3> suspects_{};
  int points_ = 0;  // in the window
  int suspect_count_ = 0, restarts_ = 0, count_ = 0;
};

}  // namespace palpate::inline time::clock_math
