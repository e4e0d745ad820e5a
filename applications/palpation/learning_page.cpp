#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "applications/palpation/difficulty.h"
#include "applications/palpation/learning_curve.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMostNamed = 12;  // sessions whose beginnings are written into a plot

double alarms_a_search(const SessionFigures& s) {
  return static_cast<double>(s.false_alarms) / static_cast<double>(s.searches);
}

std::string percent(double share) { return fmt::format("{:.0f} %", 100.0 * share); }

std::string with_interval(const std::optional<ShareInterval>& of) {
  if (!of) return "-";
  return fmt::format("{} ({:.0f} to {:.0f})", percent(of->share), 100.0 * of->low, 100.0 * of->high);
}

std::string searches_text(std::size_t number) {
  return number == 1 ? "1 search" : fmt::format("{} searches", number);
}

std::string level_text(const std::optional<double>& level) {
  return level ? fmt::format("{:.1f}", *level) : "-";
}

Json json_of(const SessionFigures& s) {
  Json json{{"session", s.session},
            {"date", s.date},
            {"searches", s.searches},
            {"nodules", s.nodules},
            {"found", s.found},
            {"found_share", nullptr},
            {"found_share_interval", nullptr},
            {"false_alarms_per_search", alarms_a_search(s)},
            {"position_error_mm_median",
             s.position_error ? Json(mm_from_metres(*s.position_error)) : Json(nullptr)},
            {"seconds_median", s.seconds},
            {"level_last_half_mean", s.late_level ? Json(*s.late_level) : Json(nullptr)}};
  if (s.found_share) {
    json["found_share"] = s.found_share->share;
    json["found_share_interval"] = {s.found_share->low, s.found_share->high};
  }
  return json;
}

std::string line_of(const SessionFigures& s) {
  std::string line = fmt::format(
      "session {} ({}): {}, found {} of {} nodules, {}; {:.2f} false alarms a "
      "search, median {:.1f} s",
      s.session, s.date.substr(0, 10), searches_text(static_cast<std::size_t>(s.searches)), s.found,
      s.nodules, with_interval(s.found_share), alarms_a_search(s), s.seconds);
  return s.late_level ? line + fmt::format(", level {:.1f} in its last half", *s.late_level) : line;
}

figures::Table table_of(const std::vector<SessionFigures>& sessions) {
  figures::Table table{{"session", "date", "searches", "found", "share, 95 %", "false alarms", "beside, mm",
                        "time, s", "level"},
                       {}};
  for (const auto& s : sessions)
    table.rows.push_back({std::to_string(s.session), excerpt(s.date.substr(0, 10), 10),
                          std::to_string(s.searches), fmt::format("{} of {}", s.found, s.nodules),
                          with_interval(s.found_share), fmt::format("{:.2f}", alarms_a_search(s)),
                          s.position_error ? fmt::format("{:.1f}", mm_from_metres(*s.position_error)) : "-",
                          fmt::format("{:.1f}", s.seconds), level_text(s.late_level)});
  return table;
}

// A curve over sessions with its points; `value` of none is a gap.
template <typename Value>
figures::Plot over_sessions(const std::vector<SessionFigures>& sessions, std::string title,
                            std::string y_label, Value value) {
  figures::Series line{.name = "session"};
  for (const auto& s : sessions) {
    line.x.push_back(s.session);
    line.y.push_back(value(s));
  }
  figures::Series points = line;
  points.mark = figures::Mark::points;
  points.in_legend = line.in_legend = false;
  figures::Plot plot;
  plot.title = std::move(title);
  plot.x_label = "session";
  plot.y_label = std::move(y_label);
  plot.from_zero = true;
  plot.x_range = {sessions.front().session - 0.5, sessions.back().session + 0.5};
  plot.series = {std::move(line), std::move(points)};
  return plot;
}

figures::Plot plot_of_share(const std::vector<SessionFigures>& sessions) {
  auto plot = over_sessions(sessions, "Nodules found", "share of the nodules, %", [](const auto& s) {
    return s.found_share ? 100.0 * s.found_share->share : kGap;
  });
  figures::Series bars{.name = "95 % interval", .tone = figures::Tone::muted, .in_legend = false};
  for (const auto& s : sessions) {
    if (!s.found_share) continue;
    bars.x.insert(bars.x.end(), {static_cast<double>(s.session), static_cast<double>(s.session), kGap});
    bars.y.insert(bars.y.end(), {100.0 * s.found_share->low, 100.0 * s.found_share->high, kGap});
  }
  plot.series.insert(plot.series.begin(), std::move(bars));
  plot.y_range = {-2.0, 102.0};
  plot.caption = "Upright: where the share may be, at 95 of 100 (Wilson); few searches tell little.";
  return plot;
}

// Every search by its level, in the order of the file.
figures::Plot plot_of_levels(std::span<const LearningLine> lines) {
  figures::Series level{.name = "level", .tone = figures::Tone::muted, .in_legend = false};
  figures::Series good{
      .name = "found all, no false alarm", .mark = figures::Mark::points, .tone = figures::Tone::good};
  figures::Series bad{
      .name = "missed one, or marked wrongly", .mark = figures::Mark::points, .tone = figures::Tone::bad};
  figures::Plot plot;
  std::size_t sessions = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double number = static_cast<double>(i + 1);
    if (i == 0 || lines[i].session != lines[i - 1].session) {
      if (++sessions <= kMostNamed)
        plot.levels.push_back(
            {.at = number - 0.5, .label = std::to_string(lines[i].session), .upright = true});
      if (i > 0) level.x.push_back(number - 0.5), level.y.push_back(kGap);
    }
    const double at = lines[i].level ? *lines[i].level : kGap;
    level.x.push_back(number);
    level.y.push_back(at);
    auto& answer = answers_positively(lines[i].nodules, lines[i].found, lines[i].false_alarms) ? good : bad;
    answer.x.push_back(number);
    answer.y.push_back(at);
  }
  plot.title = "Level, search by search";
  plot.x_label = "search, counted over all sessions";
  plot.caption = "Dashed: where each session begins, with its number.";
  plot.y_label = "level (0 easiest, 10 hardest)";
  plot.y_range = {-0.5, kHardestLevel + 0.5};
  plot.series = {std::move(level), std::move(good), std::move(bad)};
  return plot;
}

figures::Section section_of_curves(const std::vector<SessionFigures>& sessions,
                                   std::span<const LearningLine> lines) {
  figures::Section section{.title = "Over sessions", .anchor = "curves", .blocks = {}};
  const bool by_level =
      std::any_of(lines.begin(), lines.end(), [](const auto& line) { return line.level.has_value(); });
  if (by_level) {
    section.blocks.emplace_back(
        "A staircase sets how hard each search is: after two in a row that found every nodule without a "
        "false "
        "alarm the next one is harder, after one that did not it is easier. So the share of such searches "
        "stays near 71 % whatever is learned, and what is learned shows in the level that a session comes "
        "to.");
    auto late = over_sessions(sessions, "Level of a session's last half", "mean level (10 is the hardest)",
                              [](const auto& s) { return s.late_level.value_or(kGap); });
    late.y_range = {-0.5, kHardestLevel + 0.5};
    section.blocks.emplace_back(std::vector<figures::Plot>{std::move(late), plot_of_levels(lines)});
  }
  section.blocks.emplace_back(std::vector<figures::Plot>{
      plot_of_share(sessions), over_sessions(sessions, "False alarms", "false alarms a search",
                                             [](const auto& s) { return alarms_a_search(s); })});
  section.blocks.emplace_back(std::vector<figures::Plot>{
      over_sessions(sessions, "Time of a search", "median, s", [](const auto& s) { return s.seconds; }),
      over_sessions(sessions, "Marks beside their nodules", "median, mm", [](const auto& s) {
        return s.position_error ? mm_from_metres(*s.position_error) : kGap;
      })});
  return section;
}

figures::Section section_of_sessions(const std::vector<SessionFigures>& sessions,
                                     std::span<const LearningLine> lines, const std::string& source) {
  figures::Section section{.title = "What was done", .anchor = "sessions", .blocks = {}};
  section.blocks.emplace_back(fmt::format(
      "A person searched a soft organ for hard nodules hidden in it, by pressing it with a stylus, and "
      "marked "
      "where they felt one: {} in {}, from {} to {}, kept in {}. A nodule is found where a mark lies near "
      "it; a "
      "mark with no nodule near it is a false alarm. A session is one start of the program. What scripted "
      "trainees did counts as a person's.",
      searches_text(lines.size()), counted(sessions.size(), "session"),
      excerpt(lines.front().date.substr(0, 10), 10), excerpt(lines.back().date.substr(0, 10), 10), source));
  section.blocks.emplace_back(
      "Of each session: the nodules found, their share of all with the interval in which it lies at 95 of "
      "100 "
      "(Wilson), false alarms a search, the median distance from a nodule to its mark, the median time of a "
      "search, and the mean level of the session's last half, where a staircase has set levels.");
  section.blocks.emplace_back(table_of(sessions));
  return section;
}

}  // namespace

scene::StudyOutcome learning_outcome(std::span<const LearningLine> lines, const std::string& source) {
  const auto sessions = sessions_of(lines);
  scene::StudyOutcome outcome;
  outcome.values = {{"file", source}, {"searches", lines.size()}, {"sessions", Json::array()}};
  for (const auto& session : sessions) {
    outcome.values["sessions"].push_back(json_of(session));
    outcome.lines.push_back(line_of(session));
  }
  outcome.sections = {section_of_sessions(sessions, lines, source), section_of_curves(sessions, lines)};
  return outcome;
}

}  // namespace palpate::applications::palpation
