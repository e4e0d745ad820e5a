#include "applications/palpation/learning_curve.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "palpate/core/statistics.h"

namespace palpate::applications::palpation {
namespace {

// As people count: between the two middle ones where there are two.
double middle_of(std::vector<double> values) { return quantile(std::move(values), 0.5); }

SessionFigures figures_of(const std::vector<const LearningLine*>& lines) {
  SessionFigures figures;
  figures.session = lines.front()->session;
  figures.date = lines.front()->date;
  figures.searches = static_cast<int>(lines.size());
  std::vector<double> seconds, errors;
  for (const auto* line : lines) {
    figures.nodules += line->nodules;
    figures.found += line->found;
    figures.false_alarms += line->false_alarms;
    seconds.push_back(line->seconds);
    if (line->position_error) errors.push_back(*line->position_error);
  }
  figures.found_share = wilson_interval(figures.found, figures.nodules);
  figures.seconds = middle_of(std::move(seconds));
  if (!errors.empty()) figures.position_error = middle_of(std::move(errors));
  double sum = 0.0;
  int levels = 0;
  for (std::size_t i = lines.size() / 2; i < lines.size(); ++i)
    if (lines[i]->level) sum += *lines[i]->level, ++levels;
  if (levels > 0) figures.late_level = sum / levels;
  return figures;
}

}  // namespace

std::optional<ShareInterval> wilson_interval(int positives, int trials) {
  if (trials <= 0) return std::nullopt;
  constexpr double kZ = 1.959963984540054;  // standard deviations that hold 95 of 100
  const double n = trials, share = positives / n, z2 = kZ * kZ;
  const double middle = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
  const double half = kZ / (1.0 + z2 / n) * std::sqrt(share * (1.0 - share) / n + z2 / (4.0 * n * n));
  return ShareInterval{share, std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

std::vector<SessionFigures> sessions_of(std::span<const LearningLine> lines) {
  std::map<int, std::vector<const LearningLine*>> sessions;
  for (const auto& line : lines) sessions[line.session].push_back(&line);
  std::vector<SessionFigures> figures;
  for (const auto& [number, of_session] : sessions) figures.push_back(figures_of(of_session));
  return figures;
}

}  // namespace palpate::applications::palpation
