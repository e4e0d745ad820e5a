#include "palpate/calibration/internal/lag_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "palpate/calibration/internal/smooth_stream.h"

namespace palpate::calibration {
namespace {

constexpr Eigen::Index kMostChannels = 6;
constexpr double kMostGridPoints = 131072;  // of both streams
constexpr double kLeastOverlap = 0.25;      // of the shorter stream
constexpr std::size_t kMostPeaks = 10;

using Spectrum = std::vector<std::complex<double>>;
using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostChannels, kMostChannels>;

// Rates of change on a regular grid; zero, and not valid, inside gaps of the stream.
struct Rates {
  Eigen::MatrixXd rate;
  Eigen::VectorXd valid;
};

bool value_at(const LagStream& stream, double t, double longest_gap_s, Eigen::RowVectorXd& value) {
  const auto begin = stream.time_s.begin();
  const auto next = std::lower_bound(begin, stream.time_s.end(), t);
  if (next == begin || next == stream.time_s.end()) return false;
  const double gap = *next - *(next - 1);
  if (gap > longest_gap_s) return false;
  const double s = (t - *(next - 1)) / gap;
  const auto columns = std::min(kMostChannels, stream.channels.cols());
  value = (1.0 - s) * stream.channels.row(next - begin - 1).head(columns) +
          s * stream.channels.row(next - begin).head(columns);
  return true;
}

Rates rates_of(const LagStream& stream, double grid_s, double half_window_s, double longest_gap_s) {
  const auto columns = std::min(kMostChannels, stream.channels.cols());
  const auto n = static_cast<Eigen::Index>((stream.time_s.back() - stream.time_s.front()) / grid_s) + 1;
  Rates result{Eigen::MatrixXd::Zero(n, columns), Eigen::VectorXd::Zero(n)};
  Eigen::RowVectorXd before, after;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = stream.time_s.front() + static_cast<double>(i) * grid_s;
    if (!value_at(stream, t - half_window_s, longest_gap_s, before) ||
        !value_at(stream, t + half_window_s, longest_gap_s, after))
      continue;
    result.rate.row(i) = (after - before) / (2.0 * half_window_s);
    result.valid[i] = 1.0;
  }
  return result;
}

// Sums over all lags, by Fourier transforms of one length.
class Correlator {
 public:
  explicit Correlator(std::size_t length) : length_(length) {
    fft_.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  }

  Spectrum spectrum(const Eigen::VectorXd& values) {
    std::vector<double> padded(length_, 0.0);
    std::copy(values.begin(), values.end(), padded.begin());
    Spectrum result;
    fft_.fwd(result, padded);
    return result;
  }
  // sum over t of a(t) b(t + lag), at [lag] or, where negative, at [length + lag]
  std::vector<double> correlation(const Spectrum& a, const Spectrum& b) {
    Spectrum product(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) product[i] = std::conj(a[i]) * b[i];
    std::vector<double> result;
    fft_.inv(result, product, static_cast<Eigen::Index>(length_));
    return result;
  }

 private:
  std::size_t length_;
  Eigen::FFT<double> fft_;
};

// What each lag's regression needs.
struct LagSums {
  std::vector<double> both, yy;
  std::vector<std::vector<double>> xx, xy;  // lower triangle row by row; [i * response channels + j]
};

LagSums sums_of(const Rates& x, const Rates& y, Correlator& correlator) {
  const auto valid_x = correlator.spectrum(x.valid), valid_y = correlator.spectrum(y.valid);
  LagSums sums;
  sums.both = correlator.correlation(valid_x, valid_y);
  sums.yy = correlator.correlation(valid_x, correlator.spectrum(y.rate.rowwise().squaredNorm()));
  std::vector<Spectrum> y_spectra;
  for (Eigen::Index j = 0; j < y.rate.cols(); ++j) y_spectra.push_back(correlator.spectrum(y.rate.col(j)));
  for (Eigen::Index i = 0; i < x.rate.cols(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j)
      sums.xx.push_back(
          correlator.correlation(correlator.spectrum(x.rate.col(i).cwiseProduct(x.rate.col(j))), valid_y));
    const auto spectrum = correlator.spectrum(x.rate.col(i));
    for (const auto& of_y : y_spectra) sums.xy.push_back(correlator.correlation(spectrum, of_y));
  }
  return sums;
}

// R^2 of the response's rates, regressed on the features' at one lag.
double explained_share(const LagSums& sums, std::size_t at, Eigen::Index features, Eigen::Index responses) {
  if (!(sums.yy[at] > 0.0)) return 0.0;
  Small xx(features, features), xy(features, responses);
  std::size_t next = 0;
  for (Eigen::Index i = 0; i < features; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) xx(i, j) = xx(j, i) = sums.xx[next++][at];
    for (Eigen::Index j = 0; j < responses; ++j)
      xy(i, j) = sums.xy[static_cast<std::size_t>(i * responses + j)][at];
  }
  const double size = xx.trace();
  if (!(size > 0.0)) return 0.0;
  xx.diagonal().array() += 1e-7 * size;
  const Small solved = xx.llt().solve(xy);
  return std::clamp(xy.cwiseProduct(solved).sum() / sums.yy[at], 0.0, 1.0 - 1e-9);
}

// Grid points between independent samples of products of both streams.
double points_per_sample(const Rates& x, const Rates& y, Correlator& correlator) {
  const auto autocorrelation = [&](const Rates& rates) {
    std::vector<double> sum;
    for (Eigen::Index j = 0; j < rates.rate.cols(); ++j) {
      const auto spectrum = correlator.spectrum(rates.rate.col(j));
      const auto one = correlator.correlation(spectrum, spectrum);
      if (sum.empty()) sum.assign(one.size(), 0.0);
      for (std::size_t i = 0; i < one.size(); ++i) sum[i] += one[i];
    }
    for (std::size_t i = sum.size(); i-- > 0;) sum[i] /= std::max(sum[0], 1e-300);
    return sum;
  };
  const auto rx = autocorrelation(x), ry = autocorrelation(y);
  const auto most = static_cast<std::size_t>(std::min(x.valid.size(), y.valid.size()) / 4);
  double sum = 1.0;
  for (std::size_t lag = 1; lag < most; ++lag) sum += 2.0 * rx[lag] * ry[lag];
  return std::max(1.0, sum);
}

// Local maxima, between grid points by the parabola through three neighbours.
std::vector<LagPeak> peaks_of(const std::vector<LagPeak>& lags, double grid_s) {
  std::vector<LagPeak> peaks;
  for (std::size_t i = 1; i + 1 < lags.size(); ++i) {
    const double a = lags[i - 1].score, b = lags[i].score, c = lags[i + 1].score;
    if (b <= 0 || b < a || b <= c) continue;
    peaks.push_back(lags[i]);
    if (a > 0 && c > 0 && a - 2 * b + c < 0)
      peaks.back().lag_s += std::clamp(0.5 * (a - c) / (a - 2 * b + c), -0.5, 0.5) * grid_s;
  }
  std::sort(peaks.begin(), peaks.end(), [](const auto& a, const auto& b) {
    return a.score != b.score ? a.score > b.score : a.lag_s < b.lag_s;
  });
  if (peaks.size() > kMostPeaks) peaks.resize(kMostPeaks);
  return peaks;
}

}  // namespace

LagSearch search_lags(const LagStream& features, const LagStream& response, double longest_s) {
  const double x_s = features.time_s.back() - features.time_s.front(),
               y_s = response.time_s.back() - response.time_s.front();
  const double slower = std::max(sampling_period(features.time_s), sampling_period(response.time_s));
  LagSearch result;
  // 20 ms resolves a hand's motion; long recordings take a coarser grid.
  const double grid = result.grid_s = std::max(0.02, (x_s + y_s) / kMostGridPoints);
  const double half_window = std::max({0.1, grid, slower}), gap = std::max(0.2, 3.0 * slower);
  const Rates x = rates_of(features, grid, half_window, gap), y = rates_of(response, grid, half_window, gap);
  const auto nx = x.valid.size(), ny = y.valid.size();
  std::size_t length = 2;
  while (length < static_cast<std::size_t>(nx + ny)) length *= 2;
  Correlator correlator(length);
  const LagSums sums = sums_of(x, y, correlator);
  const double per_sample = points_per_sample(x, y, correlator);
  result.independent_s = per_sample * grid;
  const double least = std::max(20.0, kLeastOverlap * std::min(x.valid.sum(), y.valid.sum()));
  std::vector<LagPeak> lags;
  double tried = 1.0;
  for (Eigen::Index lag = -(nx - 1); lag < ny; ++lag) {
    LagPeak point;
    point.lag_s = response.time_s.front() - features.time_s.front() + static_cast<double>(lag) * grid;
    const auto at = static_cast<std::size_t>(lag < 0 ? static_cast<Eigen::Index>(length) + lag : lag);
    const double n = sums.both[at] / per_sample;
    // Few independent samples carry few features: the strongest.
    const auto carried = std::min(x.rate.cols(), static_cast<Eigen::Index>(0.5 * n));
    if (sums.both[at] + 0.5 >= least && n >= 4.0 && std::abs(point.lag_s) <= longest_s) {
      tried += 1.0 / per_sample;
      const auto k = static_cast<double>(carried);
      const double share = explained_share(sums, at, carried, y.rate.cols());
      const double beyond_chance = std::max(0.0, 1.0 - (1.0 - share) * n / (n - k));
      point.correlation = std::sqrt(beyond_chance);
      point.score = -0.5 * (n - k) * std::log(1.0 - beyond_chance);
    }
    lags.push_back(point);
  }
  result.chance_score = std::log(tried) + 5.0;
  result.peaks = peaks_of(lags, grid);
  return result;
}

}  // namespace palpate::calibration
