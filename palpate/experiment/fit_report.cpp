#include "palpate/experiment/fit_report.h"

#include <fmt/format.h>

#include <cmath>

namespace palpate::experiment {
namespace {

Json ends_of(const Interval& interval) {
  return Json::array({interval.low_open ? Json(nullptr) : Json(interval.low),
                      interval.high_open ? Json(nullptr) : Json(interval.high)});
}

Json finite_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// The same interval of a figure that rises with the spread.
Interval weber_of(const Interval& spread) {
  return {weber_fraction(spread.low), weber_fraction(spread.high), spread.low_open, spread.high_open};
}

std::string shown(const Interval& interval) {
  const auto end = [](double value, bool open) {
    return open ? std::string("?") : fmt::format("{:.4g}", value);
  };
  return fmt::format("{} to {}", end(interval.low, interval.low_open),
                     end(interval.high, interval.high_open));
}

}  // namespace

GroupFit fit_group(const ObservationGroup& group, const TaskShape& task, const BootstrapOptions& options) {
  GroupFit result;
  result.group = group;
  result.verdict = judge(group.levels, task);
  auto fit = fit_psychometric(group.levels, task, options.level);
  if (!fit) {
    result.refusal = fit.error().message;
    return result;
  }
  result.again = bootstrap(*fit, group.levels, task, options);
  result.fit = *fit;
  return result;
}

Json json_of(const GroupFit& one, const TaskShape& task) {
  Json json{{"by", Json::object()}, {"trials", 0}, {"levels", Json::array()}};
  int trials = 0;
  for (const auto& [column, value] : one.group.by) json["by"][column] = value;
  for (const auto& level : one.group.levels) {
    json["levels"].push_back(
        {{"stimulus", level.stimulus}, {"positives", level.positives}, {"trials", level.trials}});
    trials += level.trials;
  }
  json["trials"] = trials;
  if (!one.fit) {
    json["refused"] = {{"code", name_of(one.verdict)}, {"message", one.refusal}};
    return json;
  }
  const auto& fit = *one.fit;
  const auto& again = *one.again;
  json.update(Json{{"threshold", fit.curve.threshold},
                   {"threshold_interval", ends_of(fit.threshold)},
                   {"threshold_bootstrap", ends_of(again.threshold)},
                   {"spread", fit.curve.spread},
                   {"spread_interval", ends_of(fit.spread)},
                   {"spread_bootstrap", ends_of(again.spread)},
                   {"lapse", fit.curve.lapse},
                   {"lapse_at_bound", fit.lapse_at_bound},
                   {"stimulus_at_75", finite_or_null(stimulus_at(fit.curve, task, 0.75))},
                   {"deviance", fit.deviance},
                   {"deviance_share", again.deviance_share},
                   {"bootstrap_without_curve", again.without_curve}});
  if (task.rule == GuessRule::equals_lapse) {
    json["weber_fraction"] = weber_fraction(fit.curve.spread);
    json["weber_fraction_interval"] = ends_of(weber_of(fit.spread));
  }
  return json;
}

std::string line_of(const GroupFit& one, const TaskShape& task) {
  const auto label = label_of(one.group);
  if (!one.fit) return fmt::format("{}: {}", label, one.refusal);
  const auto& fit = *one.fit;
  auto line = fmt::format("{}: threshold {:.4g} ({}), spread {:.3g} ({})", label, fit.curve.threshold,
                          shown(fit.threshold), fit.curve.spread, shown(fit.spread));
  if (task.rule == GuessRule::equals_lapse) {
    const auto ends = weber_of(fit.spread);
    line += fmt::format(", Weber fraction {:.3g} ({})", weber_fraction(fit.curve.spread), shown(ends));
  }
  return line + fmt::format(", lapses {:.2g}, {} trials, deviance {:.3g} (share {:.2f})", fit.curve.lapse,
                            fit.trials, fit.deviance, one.again->deviance_share);
}

}  // namespace palpate::experiment
