#include "applications/palpation/press_map.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/core/statistics.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kSure = 2.5;         // standard deviations above the trend that are no chance
constexpr double kUnevenness = 0.05;  // of log forces that no smooth trend explains
constexpr double kStandsOut =
    1.5;  // deviations (of the median's kind) above which the trend leaves a place out
constexpr int kFits = 4;
constexpr double kNetShare = 0.25;  // of the spacing

Eigen::MatrixXd basis_of(const std::vector<PlanPlace>& places, const std::vector<std::size_t>& rows,
                         bool level) {
  constexpr double kUnit_m = 0.03;  // keeps columns of one size
  Eigen::MatrixXd basis(static_cast<Eigen::Index>(rows.size()), level ? 1 : 6);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const PlanPlace p = places[rows[i]] / kUnit_m;
    const auto row = static_cast<Eigen::Index>(i);
    if (level)
      basis(row, 0) = 1.0;
    else
      basis.row(row) << 1.0, p.x(), p.y(), p.x() * p.x(), p.x() * p.y(), p.y() * p.y();
  }
  return basis;
}

}  // namespace

std::vector<PlanPlace> grid_of(const PlanPlace& centre, const PlanPlace& half, double spacing) {
  std::vector<PlanPlace> places;
  const auto lines = [&](double reach) { return static_cast<int>(std::floor(reach / spacing)); };
  bool back = false;
  for (int row = -lines(half.y()); row <= lines(half.y()); ++row, back = !back)
    for (int k = -lines(half.x()); k <= lines(half.x()); ++k) {
      const PlanPlace from_centre((back ? -k : k) * spacing, row * spacing);
      if (from_centre.cwiseQuotient(half).squaredNorm() <= 1.0) places.emplace_back(centre + from_centre);
    }
  return places;
}

PressMap::PressMap(std::vector<PlanPlace> places, double spacing, double noise, Trend trend)
    : places_(std::move(places)),
      spacing_(spacing),
      noise_(noise),
      trend_(trend),
      sum_(places_.size(), 0.0),
      count_(places_.size(), 0) {}

std::size_t PressMap::add_place(const PlanPlace& place) {
  places_.push_back(place);
  sum_.push_back(0.0);
  count_.push_back(0);
  return places_.size() - 1;
}

void PressMap::felt(std::size_t place, double log_force) {
  sum_[place] += log_force;
  ++count_[place];
}

std::vector<double> PressMap::hardness() const {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (count_[i] > 0) all.push_back(i);
  std::vector<double> above(places_.size(), 0.0);
  const bool level = trend_ == Trend::level || all.size() < 12;
  if (all.empty()) return above;
  std::vector<std::size_t> used = all;
  for (int fit = 0; fit < kFits; ++fit) {
    const Eigen::MatrixXd basis = basis_of(places_, used, level);
    Eigen::VectorXd values(basis.rows());
    for (std::size_t i = 0; i < used.size(); ++i) values[static_cast<Eigen::Index>(i)] = mean(used[i]);
    const Eigen::VectorXd trend = basis.colPivHouseholderQr().solve(values);
    const Eigen::VectorXd expected = basis_of(places_, all, level) * trend;
    std::vector<double> deviations;
    for (std::size_t i = 0; i < all.size(); ++i) {
      above[all[i]] = mean(all[i]) - expected[static_cast<Eigen::Index>(i)];
      deviations.push_back(std::abs(above[all[i]]));
    }
    const double limit = kStandsOut * 1.4826 * median(deviations);
    used.clear();
    for (const auto i : all)
      if (above[i] <= limit) used.push_back(i);
    if (used.size() < 10) break;
  }
  return above;
}

std::vector<std::size_t> PressMap::best(std::size_t count) const {
  const auto hard = hardness();
  std::vector<std::size_t> order(places_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if ((count_[a] > 0) != (count_[b] > 0)) return count_[a] > 0;
    return hard[a] > hard[b];
  });
  order.resize(std::min(count, order.size()));
  return order;
}

std::vector<PlanPlace> PressMap::likeliest(std::size_t count, double apart) const {
  const NoduleOdds odds = weigh();
  std::vector<std::pair<double, PlanPlace>> net;
  const double step = kNetShare * spacing_;
  for (const auto& place : places_)
    for (int i = -1; i <= 2; ++i)  // up to half a spacing, each place once
      for (int k = -1; k <= 2; ++k) {
        const PlanPlace at = place + step * PlanPlace(i, k);
        net.emplace_back(odds.of(at), at);
      }
  std::stable_sort(net.begin(), net.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<PlanPlace> chosen;
  for (const auto& [odds_there, at] : net) {
    if (chosen.size() == count) break;
    const bool near = std::any_of(chosen.begin(), chosen.end(), [&, &here = at](const PlanPlace& other) {
      return (other - here).norm() < apart;
    });
    if (!near) chosen.push_back(at);
  }
  return chosen;
}

NoduleOdds PressMap::weigh() const {
  std::vector<PlanPlace> pressed;
  std::vector<double> felt, variances;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (count_[i] == 0) continue;
    pressed.push_back(places_[i]);
    felt.push_back(mean(i));
    variances.push_back(noise_ * noise_ / static_cast<double>(count_[i]) + kUnevenness * kUnevenness);
  }
  return {std::move(pressed), felt, variances, trend_ == Trend::level};
}

std::vector<PlanPlace> PressMap::believed(std::size_t fewest, std::size_t most, double apart) const {
  const NoduleOdds odds = weigh();
  std::vector<PlanPlace> found;
  for (const PlanPlace& at : likeliest(most, apart))
    if (found.size() < fewest || odds.deviations(at) > kSure) found.push_back(at);
  return found;
}

}  // namespace palpate::applications::palpation
