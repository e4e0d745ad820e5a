#include "palpate/evaluation/report/plot_json.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "palpate/core/json.h"

namespace palpate::evaluation::report {
namespace {

const char* name_of(figures::Tone tone) {
  switch (tone) {
    case figures::Tone::ours:
      return "ours";
    case figures::Tone::rival:
      return "rival";
    case figures::Tone::third:
      return "third";
    case figures::Tone::fourth:
      return "fourth";
    case figures::Tone::muted:
      return "muted";
    case figures::Tone::good:
      return "good";
    case figures::Tone::bad:
      return "bad";
  }
  return "ours";
}

const char* name_of(figures::Mark mark) {
  switch (mark) {
    case figures::Mark::line:
      return "line";
    case figures::Mark::points:
      return "points";
    case figures::Mark::steps:
      return "steps";
    case figures::Mark::bars:
      return "bars";
    case figures::Mark::area:
      return "area";
  }
  return "line";
}

std::string text(const std::string& value) {
  return Json(value).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string texts(const std::vector<std::string>& values) {
  std::string out = "[";
  for (const auto& value : values) out += (out.size() > 1 ? "," : "") + text(value);
  return out + "]";
}

const char* yes(bool value) { return value ? "true" : "false"; }

}  // namespace

std::string json_numbers(const std::vector<double>& values, bool relative) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (double v : values) {
    if (!std::isfinite(v)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  const double span = high > low ? high - low : (high == low ? std::max(std::abs(high), 1e-12) : 1.0);
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(span * 1e-4))), 0, 15);
  std::string out = "[";
  for (double v : values) {
    if (out.size() > 1) out += ',';
    if (!std::isfinite(v)) {
      out += "null";
    } else if (relative) {
      fmt::format_to(std::back_inserter(out), "{:.4g}", v);
    } else {
      std::string number = fmt::format("{:.{}f}", v, decimals);
      if (number.find('.') != std::string::npos) {
        number.erase(number.find_last_not_of('0') + 1);
        if (number.back() == '.') number.pop_back();
      }
      out += number == "-0" ? "0" : number;
    }
  }
  return out + "]";
}

std::string plot_json(const figures::Plot& plot) {
  std::string out = fmt::format(
      "{{\"title\":{},\"x\":{},\"y\":{},\"equal\":{},\"logx\":{},\"logy\":{},\"sideways\":{},"
      "\"flipx\":{},\"flipy\":{},\"zero\":{},\"stacked\":{},\"series\":[",
      text(plot.title), text(plot.x_label), text(plot.y_label), yes(plot.equal_axes), yes(plot.log_x),
      yes(plot.log_y), yes(plot.sideways), yes(plot.flip_x), yes(plot.flip_y), yes(plot.from_zero),
      yes(plot.stacked));
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const figures::Series& s = plot.series[i];
    out += fmt::format(
        "{}{{\"name\":{},\"mark\":\"{}\",\"tone\":\"{}\",\"legend\":{},\"dashed\":{},\"filled\":{},\"x\":{},"
        "\"y\":{},\"hover\":{},\"written\":{}}}",
        i ? "," : "", text(s.name), name_of(s.mark), name_of(s.tone), yes(s.in_legend), yes(s.dashed),
        yes(s.filled), s.labels.empty() ? json_numbers(s.x, plot.log_x) : texts(s.labels),
        json_numbers(s.y, plot.log_y), texts(s.hover), texts(s.written));
  }
  out += "],\"levels\":[";
  for (std::size_t i = 0; i < plot.levels.size(); ++i) {
    const figures::Level& level = plot.levels[i];
    out += fmt::format("{}{{\"at\":{:.6g},\"to\":{:.6g},\"label\":{},\"tone\":\"{}\",\"upright\":{}}}",
                       i ? "," : "", level.at, level.to.value_or(level.at), text(level.label),
                       name_of(level.tone), yes(level.upright));
  }
  out += "]";
  if (plot.y_range[0] != plot.y_range[1])
    out += ",\"yrange\":" + json_numbers({plot.y_range[0], plot.y_range[1]}, true);
  if (plot.x_range[0] != plot.x_range[1])
    out += ",\"xrange\":" + json_numbers({plot.x_range[0], plot.x_range[1]}, true);
  return out + "}";
}

std::string cloud_json(const figures::Cloud& cloud) {
  std::string out = fmt::format("{{\"unit\":{},\"up\":{},\"turn\":{:.1f},\"tilt\":{:.1f},\"groups\":[",
                                text(cloud.unit), cloud.up, cloud.turn_deg, cloud.tilt_deg);
  for (std::size_t i = 0; i < cloud.groups.size(); ++i) {
    const figures::CloudGroup& group = cloud.groups[i];
    std::vector<double> flat;
    flat.reserve(group.points.size() * 3);
    for (const auto& point : group.points) flat.insert(flat.end(), point.begin(), point.end());
    out += fmt::format("{}{{\"name\":{},\"tone\":\"{}\",\"joined\":{},\"size\":{:.1f},\"p\":{}}}",
                       i ? "," : "", text(group.name), name_of(group.tone), yes(group.joined), group.size_px,
                       json_numbers(flat));
  }
  return out + "]}";
}

}  // namespace palpate::evaluation::report
