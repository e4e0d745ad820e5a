#include "palpate/calibration/motion_delay.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/calibration/internal/lag_search.h"
#include "palpate/calibration/internal/shift_fit.h"
#include "palpate/calibration/internal/smooth_stream.h"
#include "palpate/core/text.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr double kLever = 0.2;        // m: a turn by a radian counts like this change of place
constexpr double kLeastShare = 1e-5;  // of a stream's variance: weaker directions hold noise
constexpr std::size_t kFewestRows = 20;
constexpr double kUnseen = 1e-5;           // of a motion's variance: less is no difference between two delays
constexpr double kLeastCorrelation = 0.5;  // below it little of the one is in the other
constexpr std::size_t kMostNamed = 4;
constexpr double kLooseShare = 0.25;   // of the time in which the motion changes: a poor deviation
constexpr double kNearlyAsGood = 4.0;  // times the unexplained share of the best delay
constexpr double kRhythmCorrelation = 0.95, kRhythmBetter = 2.0;  // see in_step()

Motion sorted(std::string name, const std::vector<double>& time_s, const Eigen::MatrixXd& channels) {
  std::vector<std::size_t> order(time_s.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return time_s[a] < time_s[b]; });
  Motion motion{std::move(name), {}, {}};
  std::vector<Eigen::Index> kept;
  for (const auto i : order) {
    if (!motion.time_s.empty() && time_s[i] == motion.time_s.back()) continue;
    motion.time_s.push_back(time_s[i]);
    kept.push_back(static_cast<Eigen::Index>(i));
  }
  motion.channels = channels(kept, Eigen::all);
  return motion;
}

// A stream in the directions in which it changes, the largest first, about its mean.
struct Changing {
  std::vector<double> time_s;
  Eigen::MatrixXd channels;
};

Expected<Changing> changing(const Motion& motion) {
  if (motion.time_s.size() < kFewestRows)
    return refused("delay: {} holds {} at different times; at least {} are needed", motion.name,
                   counted(motion.time_s.size(), "sample"), kFewestRows);
  const Eigen::RowVectorXd mean = motion.channels.colwise().mean();
  const Eigen::MatrixXd about_mean = motion.channels.rowwise() - mean;
  const auto eigen = symmetric_eigen(gram(about_mean) / static_cast<double>(about_mean.rows()));
  const double largest = eigen.values.maxCoeff(), size = 1.0 + mean.squaredNorm();
  if (!(largest > 1e-24 * size))
    return refused("delay: {} does not change; a recording of a motion is expected", motion.name);
  const auto strong = (eigen.values.array() > kLeastShare * largest).count();
  return Changing{motion.time_s, about_mean * eigen.vectors.rightCols(strong).rowwise().reverse()};
}

// The streams in the roles that they have in search and fit.
struct Roles {
  bool features_are_from;  // the stream with more channels, else the finer one
  bool sampled_is_from;    // the slower one
};

struct Fitted {
  double delay_s;
  ShiftFit fit;
};

std::vector<Fitted> fit_all(const Changing& from, const Changing& to, const Roles& roles,
                            const LagSearch& search, double longest_s) {
  const Changing &sampled = roles.sampled_is_from ? from : to, &other = roles.sampled_is_from ? to : from;
  const SmoothStream sampled_smooth(sampled.time_s, sampled.channels);
  const SmoothStream read(other.time_s, other.channels, 0.25 * sampling_period(sampled.time_s));
  const ShiftProblem problem{sampled.time_s,
                             sampled.channels,
                             sampled_smooth,
                             read,
                             roles.features_are_from != roles.sampled_is_from,
                             search.independent_s};
  std::vector<Fitted> all;
  for (const auto& peak : search.peaks) {
    if (peak.score < 0.2 * search.peaks.front().score) break;
    const double delay = roles.features_are_from ? peak.lag_s : -peak.lag_s;
    const auto fit =
        fit_shift(problem, roles.sampled_is_from ? delay : -delay, std::max(0.1, 3.0 * search.grid_s));
    if (!fit || !std::isfinite(fit->std_s)) continue;
    const double found = roles.sampled_is_from ? fit->shift_s : -fit->shift_s;
    const bool known = std::any_of(all.begin(), all.end(), [&](const Fitted& f) {
      return std::abs(f.delay_s - found) < 0.5 * search.grid_s;
    });
    if (!known && std::abs(found) <= longest_s) all.push_back({found, *fit});
  }
  return all;
}

// How good a fit is: the logarithm of its likelihood over that of no relation, by independent samples of the motion.
double merit(const Fitted& f, double independent_s) {
  return -f.fit.overlap_s / independent_s * std::log(std::max(f.fit.unexplained, 1e-12));
}

// Where a motion is too slow for the search to count many independent samples, exact recordings still tell: the best
// delay fits far better than any other.
bool stands_out(const std::vector<Fitted>& fits, double independent_s, double shorter_s) {
  // A short stretch is fitted by that many features whatever it shows.
  return fits.size() > 1 && fits[0].fit.overlap_s > 0.5 * shorter_s &&
         merit(fits[0], independent_s) > 2.0 * merit(fits[1], independent_s) + 10.0;
}

// A probe moved up and down, a pendulum: two rhythms of one period correlate whether they belong together or not, and few samples
// of them are independent. What a shift by whole periods leaves unexplained is about the same each time, unless one of them makes
// the strokes' own differences agree, too: that one leaves less than half of every other's. Taken where it is the nearest to no delay as well, for clocks
// with a common origin; where the delay was limited nothing else is in question.
bool in_step(const std::vector<Fitted>& fits, double longest_s, double shorter_s) {
  const Fitted& best = fits.front();
  if (best.fit.correlation < kRhythmCorrelation || best.fit.overlap_s < 0.5 * shorter_s) return false;
  if (fits.size() == 1) return std::isfinite(longest_s);
  return std::all_of(fits.begin() + 1, fits.end(), [&](const Fitted& other) {
    return other.fit.unexplained > kRhythmBetter * best.fit.unexplained &&
           std::abs(other.delay_s) > std::abs(best.delay_s);
  });
}

std::string named(const std::vector<Fitted>& fits) {
  std::string text;
  for (std::size_t i = 0; i < std::min(fits.size(), kMostNamed); ++i)
    text += fmt::format("{}{:.4f} s (correlation {:.4f})", i > 0 ? ", " : "", fits[i].delay_s,
                        fits[i].fit.correlation);
  return text + (fits.size() > kMostNamed ? ", ..." : "");
}

// The unexplained share up to which another delay fits as well as the best one, as far as its noise can tell.
double as_good_share(const ShiftFit& best) {
  const double n = std::max(1.0, best.effective_rows);
  const double share = std::max({0.05, 12.0 / n, 3.0 * std::sqrt(2.0 / n)});
  return std::max(best.unexplained * (1.0 + share), kUnseen);
}

std::string spans(const Motion& from, const Motion& to) {
  return fmt::format("{} covers {:.3f} to {:.3f} s, {} covers {:.3f} to {:.3f} s", from.name,
                     from.time_s.front(), from.time_s.back(), to.name, to.time_s.front(), to.time_s.back());
}

void add_warnings(MotionDelay& answer, const Motion& from, const Motion& to, const std::vector<Fitted>& fits,
                  const LagSearch& search) {
  auto& w = answer.warnings;
  const auto& best = fits.front().fit;
  if (fits.size() > 1 && fits[1].fit.unexplained < std::max(kNearlyAsGood * best.unexplained, 0.02))
    w.push_back(
        fmt::format("the motion nearly repeats itself: a delay of {:.4f} s fits almost as well (correlation "
                    "{:.4f} against "
                    "{:.4f}); record a motion without a rhythm to be sure",
                    fits[1].delay_s, fits[1].fit.correlation, best.correlation));
  if (from.time_s.back() < to.time_s.front() || to.time_s.back() < from.time_s.front())
    w.push_back(
        fmt::format("the stamps have no span in common ({}): the clocks have different origins, or one "
                    "recording is of another motion",
                    spans(from, to)));
  if (answer.delay_std_s > kLooseShare * search.independent_s)
    w.push_back(
        fmt::format("the delay is known to {:.1f} ms only, for a motion that changes within {:.0f} ms; move "
                    "faster and record longer",
                    1e3 * answer.delay_std_s, 1e3 * search.independent_s));
  if (answer.overlap_s < 5.0)
    w.push_back(
        fmt::format("the two have {:.1f} s in common, which is little: another stretch of the motion may fit "
                    "as well; record 20 s and more",
                    answer.overlap_s));
  if (answer.correlation < 0.9)
    w.push_back(
        fmt::format("correlation is {:.3f} only: {} explains little of {}, or not in straight proportion",
                    answer.correlation, from.channels.cols() >= to.channels.cols() ? from.name : to.name,
                    from.channels.cols() >= to.channels.cols() ? to.name : from.name));
}

}  // namespace

Motion motion_of_poses(std::string name, const std::vector<device::StampedPose>& poses) {
  const auto n = static_cast<Eigen::Index>(poses.size());
  Eigen::MatrixXd channels(n, 12);
  std::vector<double> time_s;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& pose = poses[static_cast<std::size_t>(i)];
    time_s.push_back(pose.time_s);
    // The entries' squares change by twice the square of the angle.
    const Matrix3 R = kLever / std::sqrt(2.0) * pose.rotation.toRotationMatrix();
    channels.row(i) << R.row(0), R.row(1), R.row(2), pose.translation.transpose();
  }
  return sorted(std::move(name), time_s, channels);
}

Motion motion_of_points(std::string name, const std::vector<TimedPoint>& points) {
  Eigen::MatrixXd channels(static_cast<Eigen::Index>(points.size()), 3);
  std::vector<double> time_s;
  for (const auto& point : points) {
    channels.row(static_cast<Eigen::Index>(time_s.size())) = point.place.transpose();
    time_s.push_back(point.time_s);
  }
  return sorted(std::move(name), time_s, channels);
}

Motion motion_of_signal(std::string name, const std::vector<double>& time_s,
                        const std::vector<double>& values) {
  const Eigen::MatrixXd column =
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  return sorted(std::move(name), time_s, column);
}

Expected<MotionDelay> estimate_motion_delay(const Motion& from_motion, const Motion& to_motion,
                                            const MotionDelayOptions& options) {
  const auto from = changing(from_motion);
  if (!from) return tl::unexpected(from.error());
  const auto to = changing(to_motion);
  if (!to) return tl::unexpected(to.error());
  const bool from_slower = sampling_period(from->time_s) > sampling_period(to->time_s);
  const auto from_width = from->channels.cols(), to_width = to->channels.cols();
  const Roles roles{from_width != to_width ? from_width > to_width : !from_slower, from_slower};
  const LagStream a{from->time_s, from->channels}, b{to->time_s, to->channels};
  const LagSearch search =
      roles.features_are_from ? search_lags(a, b, options.longest_s) : search_lags(b, a, options.longest_s);
  auto fits = fit_all(*from, *to, roles, search, options.longest_s);
  std::stable_sort(fits.begin(), fits.end(), [&](const Fitted& x, const Fitted& y) {
    return merit(x, search.independent_s) > merit(y, search.independent_s);
  });
  const double shorter_s =
      std::min(from->time_s.back() - from->time_s.front(), to->time_s.back() - to->time_s.front());
  const bool many = !search.peaks.empty() && search.peaks.front().score >= search.chance_score;
  const bool rhythm = !many && !fits.empty() && !stands_out(fits, search.independent_s, shorter_s);
  const bool by_chance = rhythm && !in_step(fits, options.longest_s, shorter_s);
  if (by_chance && fits.front().fit.correlation >= kRhythmCorrelation)
    return refused(
        "delay: the motion is a rhythm of a few strokes, and any two of one period fit: {}; record a motion "
        "without "
        "a rhythm, or limit the delay (--longest-s; longest_s in Python) to less than half of a stroke",
        named(fits));
  if (fits.empty() || by_chance || fits.front().fit.correlation < kLeastCorrelation)
    return refused(
        "delay: no common time span is found: at no delay do {} and {} move together better than chance "
        "would have it ({}{}); record one motion with both, larger and longer",
        from_motion.name, to_motion.name, spans(from_motion, to_motion),
        fits.empty() ? "" : "; best: " + named({fits.front()}));
  const auto& best = fits.front();
  std::vector<Fitted> as_good;
  for (const auto& f : fits)
    if (f.fit.unexplained <= as_good_share(best.fit)) as_good.push_back(f);
  if (as_good.size() > 1)
    return refused(
        "delay: the motion repeats itself, several delays fit about equally well: {}; record a motion "
        "without a rhythm, or limit the delay (--longest-s; longest_s in Python)",
        named(as_good));
  MotionDelay answer;
  answer.delay_s = best.delay_s;
  answer.delay_std_s = best.fit.std_s;
  answer.correlation = best.fit.correlation;
  answer.overlap_s = best.fit.overlap_s;
  answer.samples = best.fit.rows;
  answer.noise_memory_s = best.fit.memory_s;
  answer.std_grown_by = best.fit.grown_by;
  for (std::size_t i = 1; i < fits.size(); ++i)
    answer.others.push_back({fits[i].delay_s, fits[i].fit.correlation});
  add_warnings(answer, from_motion, to_motion, fits, search);
  if (rhythm)
    answer.warnings.emplace_back(
        "the motion is a rhythm of a few strokes, which two recordings may share by chance: the delay holds "
        "where both are of one motion; record a motion without a rhythm to be sure");
  return answer;
}

}  // namespace palpate::calibration
