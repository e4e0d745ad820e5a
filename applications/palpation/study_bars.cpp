#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "applications/palpation/study_parts.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kManyDeviations = 4.0;  // standard deviations
constexpr double kSearchPoints = 3.0;    // of the table, per cent
constexpr double kChanceOfSearch = 5.0;  // "about", per cent

StudyBar sense_off_bar(const StudyFindings& all) {
  double right = 0.0, trials = 0.0;
  for (const auto& fit : all.named("sense-off").fits)
    for (const auto& level : fit.group.levels) right += level.positives, trials += level.trials;
  const double share = right / trials, limit = kManyDeviations * 0.5 / std::sqrt(trials);
  return {"sense off: share right of two places", share, fmt::format("0.5, {:.3f} more or less", limit),
          std::abs(share - 0.5) <= limit};
}

StudyBar sense_off_search_bar(const StudyFindings& all) {
  const double limit = kManyDeviations * 100.0 * std::sqrt(0.05 * 0.95 / all.plan.searches) + 0.5;
  return {"sense off: searches that found, per cent", all.numb_search,
          fmt::format("about {:.0f}, {:.1f} more or less", kChanceOfSearch, limit),
          std::abs(all.numb_search - kChanceOfSearch) <= limit};
}

StudyBar search_bar(const StudyFindings& all) {
  double worst = 0.0;
  for (const auto& row : all.searches)
    for (std::size_t k = 0; k < row.grid.size(); ++k)
      worst = std::max(worst, std::abs(row.grid[k] - row.reference[k]));
  return {"searching grid: worst difference from the table, points", worst,
          fmt::format("at most {:.0f}", kSearchPoints), worst <= kSearchPoints};
}

// Where something late and something that is not feel alike; none where the answers tell no curve.
const experiment::PsychometricFit* equal_at(const StudyFindings& all, std::string_view late) {
  for (const auto& one : all.named("felt-late").fits)
    if (one.group.by.front().second == late) return one.fit ? &*one.fit : nullptr;
  return nullptr;
}

void add_delay_bars(const StudyFindings& all, std::vector<StudyBar>& bars) {
  const auto *force = equal_at(all, "force"), *picture = equal_at(all, "picture"),
             *both = equal_at(all, "both");
  if (force == nullptr || picture == nullptr || both == nullptr || !(all.plan.trainee.late_s > 0.0)) return;
  bars.push_back({"late force: as stiff as what is not late at so many times its stiffness",
                  force->curve.threshold, "above 1: it feels softer", force->threshold.low > 1.0});
  bars.push_back({"late picture: the same", picture->curve.threshold, "below 1: it feels stiffer",
                  picture->threshold.high < 1.0});
  const double bias = std::log(both->curve.threshold);
  bars.push_back({"both late: the same", both->curve.threshold, "between the two: they partly cancel",
                  bias < std::log(force->curve.threshold) && bias > std::log(picture->curve.threshold) &&
                      std::abs(bias) < std::max(std::abs(std::log(force->curve.threshold)),
                                                std::abs(std::log(picture->curve.threshold)))});
}

void add_sight_bar(const StudyFindings& all, std::vector<StudyBar>& bars) {
  const auto& fits = all.named("depth").fits;
  if (!fits[0].fit || !fits[1].fit) return;
  const double with = 1.0 / fits[0].fit->curve.threshold, without = 1.0 / fits[1].fit->curve.threshold;
  bars.push_back({"sight: deepest nodule told three times in four, with it over without it", with / without,
                  "above 1", with > without});
}

}  // namespace

std::vector<StudyBar> bars_of(const StudyFindings& all) {
  std::vector<StudyBar> bars{sense_off_bar(all), sense_off_search_bar(all), search_bar(all)};
  add_delay_bars(all, bars);
  add_sight_bar(all, bars);
  return bars;
}

}  // namespace palpate::applications::palpation
