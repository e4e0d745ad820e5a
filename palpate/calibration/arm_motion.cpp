#include "palpate/calibration/arm_motion.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace palpate::calibration {
namespace {

constexpr double kStillRate = 0.02;   // rad/s: slower is noise of the encoders
constexpr double kStillTurn = 0.002;  // rad between poses held still

std::vector<std::size_t> in_time_order(const std::vector<device::ArmObservation>& samples) {
  std::vector<std::size_t> order(samples.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return *samples[a].time_s < *samples[b].time_s; });
  return order;
}

// Readings over time, rows in time order.
struct Track {
  std::vector<double> times;
  std::vector<Eigen::VectorXd> values, rates;

  Track(std::vector<double> t, std::vector<Eigen::VectorXd> v) : times(std::move(t)), values(std::move(v)) {
    for (std::size_t i = 0; i < times.size(); ++i) rates.push_back(tangent(i));
  }

  bool joined(std::size_t i) const {  // i and i + 1
    return i + 1 < times.size() && times[i + 1] > times[i] && times[i + 1] - times[i] <= kMotionGap;
  }

  Eigen::VectorXd slope(std::size_t i) const {
    return (values[i + 1] - values[i]) / (times[i + 1] - times[i]);
  }

  Eigen::VectorXd tangent(std::size_t i) const {
    const bool before = i > 0 && joined(i - 1), after = joined(i);
    if (before && after) {
      const double h0 = times[i] - times[i - 1], h1 = times[i + 1] - times[i];
      return (h1 * slope(i - 1) + h0 * slope(i)) / (h0 + h1);
    }
    if (before) return slope(i - 1);
    if (after) return slope(i);
    return Eigen::VectorXd::Zero(values[i].size());
  }

  // Near row i, at time t.
  void at(std::size_t i, double t, Eigen::VectorXd& value, Eigen::VectorXd& rate) const {
    while (i > 0 && t < times[i] && joined(i - 1)) --i;
    while (joined(i) && t > times[i + 1]) ++i;
    if (!joined(i) || t < times[i]) {  // at an end: goes on as it went
      value = values[i] + (t - times[i]) * rates[i];
      rate = rates[i];
      return;
    }
    const double h = times[i + 1] - times[i], u = (t - times[i]) / h;
    const double u2 = u * u, u3 = u2 * u;
    value = (2 * u3 - 3 * u2 + 1) * values[i] + (u3 - 2 * u2 + u) * h * rates[i] +
            (3 * u2 - 2 * u3) * values[i + 1] + (u3 - u2) * h * rates[i + 1];
    rate = 6 * (u2 - u) / h * (values[i] - values[i + 1]) + (3 * u2 - 4 * u + 1) * rates[i] +
           (3 * u2 - 2 * u) * rates[i + 1];
  }
};

template <typename Read>
Track track_of(const std::vector<device::ArmObservation>& samples, const std::vector<std::size_t>& order,
               Read read) {
  std::vector<double> times;
  std::vector<Eigen::VectorXd> values;
  for (std::size_t i : order) {
    times.push_back(*samples[i].time_s);
    values.push_back(read(samples[i]));
  }
  return {std::move(times), std::move(values)};
}

}  // namespace

bool all_have_times(const std::vector<device::ArmObservation>& samples) {
  return std::all_of(samples.begin(), samples.end(), [](const auto& s) { return s.time_s.has_value(); });
}

bool taken_in_motion(const std::vector<device::ArmObservation>& samples) {
  if (samples.size() < 2 || !all_have_times(samples)) return false;
  const auto order = in_time_order(samples);
  std::size_t close = 0;
  for (std::size_t k = 1; k < order.size(); ++k)
    if (*samples[order[k]].time_s - *samples[order[k - 1]].time_s <= kMotionGap) ++close;
  return 2 * close > samples.size();
}

std::vector<ArmMotion> arm_motions(const std::vector<device::ArmObservation>& samples, double delay_s) {
  std::vector<ArmMotion> motions(samples.size());
  if (samples.empty() || !all_have_times(samples)) {
    for (std::size_t i = 0; i < samples.size(); ++i) motions[i].joints = samples[i].joints;
    return motions;
  }
  const auto order = in_time_order(samples);
  const Track track = track_of(samples, order, [](const device::ArmObservation& s) { return s.joints; });
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(samples[0].joints.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    ArmMotion& motion = motions[order[k]];
    track.at(k, track.times[k] - delay_s, motion.joints, motion.rate);
    const bool moving = track.joined(k) || (k > 0 && track.joined(k - 1));
    for (Eigen::Index j = 0; j < direction.size(); ++j) {
      const double turned =
          moving ? motion.rate[j] : (k > 0 ? track.values[k][j] - track.values[k - 1][j] : 0.0);
      if (std::abs(turned) > (moving ? kStillRate : kStillTurn)) direction[j] = turned > 0.0 ? 1.0 : -1.0;
    }
    motion.direction = direction;
  }
  return motions;
}

std::vector<device::ArmObservation> with_delay_removed(const std::vector<device::ArmObservation>& samples,
                                                       double delay_s) {
  auto result = samples;
  if (delay_s == 0.0 || samples.empty() || !all_have_times(samples)) return result;
  const auto motions = arm_motions(samples, delay_s);
  for (std::size_t i = 0; i < samples.size(); ++i) result[i].joints = motions[i].joints;
  if (!std::all_of(samples.begin(), samples.end(), [](const auto& s) { return s.gimbal.has_value(); }))
    return result;
  const auto order = in_time_order(samples);
  const Track track =
      track_of(samples, order, [](const device::ArmObservation& s) { return Eigen::VectorXd(*s.gimbal); });
  Eigen::VectorXd value, rate;
  for (std::size_t k = 0; k < order.size(); ++k) {
    track.at(k, track.times[k] - delay_s, value, rate);
    result[order[k]].gimbal = Vector3(value);
  }
  return result;
}

}  // namespace palpate::calibration
