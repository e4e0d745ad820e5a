#include "palpate/evaluation/report/format.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <kainjow/mustache.hpp>
#include <limits>

#include "palpate/core/base64.h"
#include "palpate/core/file.h"
#include "palpate/figures/play_folder.h"

namespace palpate::evaluation::report {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double number_of(const Json& value) { return value.is_number() ? value.get<double>() : kNone; }

std::string whole(const Json& value) {
  if (value.is_null()) return "\u2014";
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_number_float()) return value.dump();
  std::string number = fmt::format("{:g}", value.get<double>());
  if (const auto at = number.find("e-0"); at != std::string::npos) number.erase(at + 2, 1);
  return number;
}

std::string with_unit(const std::string& number, std::string_view unit) {
  return unit.empty() ? number : number + (unit == "\u00b0" ? "" : "\u00a0") + std::string(unit);
}

// "3 mm", "+.1f %".
std::string as_number(const Json& value, std::string_view digits, std::string_view unit) {
  if (value.is_string()) return value.get<std::string>();
  const bool percent = unit == "percent";
  const double number = (unit == "%" || percent ? 100.0 : 1.0) * number_of(value);
  if (!std::isfinite(number)) return "\u2014";
  if (percent) unit = "";
  if (digits.find_first_not_of("0123456789") == std::string_view::npos)
    return figures::shown(number, unit, std::stoi(std::string(digits)));
  return with_unit(fmt::format(fmt::runtime(fmt::format("{{:{}}}", digits)), number), unit);
}

// Escaped, with what stands between backticks as code.
std::string prose(const std::string& text) {
  std::string out;
  bool inside = false;
  for (const char c : kainjow::mustache::html_escape(text)) {
    if (c != '`') {
      out += c;
      continue;
    }
    out += inside ? "</code>" : "<code>";
    inside = !inside;
  }
  return inside ? out + "</code>" : out;
}

// A file that a page names lies in the folder or below it.
std::string data_address(const Json& value, const std::filesystem::path& folder) {
  const std::filesystem::path file = value.is_string() ? value.get<std::string>() : "";
  const bool below = file.is_relative() && std::find(file.begin(), file.end(), "..") == file.end();
  if (file.empty() || !below) return "";
  const auto bytes = read_file(folder / file);
  if (!bytes) return "";
  return fmt::format("data:{};base64,{}", file.extension() == ".mp4" ? "video/mp4" : "image/png",
                     base64(*bytes));
}

std::string listed(const Json& value, bool relative) {
  std::vector<double> numbers;
  if (value.is_array())
    for (const auto& one : value) numbers.push_back(number_of(one));
  return json_numbers(numbers, relative);
}

bool compared(const Json& value, char how, double with) {
  const double number = number_of(value);
  return how == '>' ? number > with : how == '<' ? number < with : number == with;
}

}  // namespace

std::string formatted(const Json& value, std::string_view format, const std::filesystem::path& folder) {
  if (format.empty()) return whole(value);
  const auto space = format.find(' ');
  const std::string_view first = format.substr(0, space),
                         rest = space == std::string_view::npos ? "" : format.substr(space + 1);
  if (first == "json") return value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (first == "prose") return value.is_null() ? "" : prose(whole(value));
  if (first == "numbers") return listed(value, rest == "log");
  if (first == "data") return data_address(value, folder);
  if (first == "us")
    return number_of(value) < 1000.0 ? figures::shown(number_of(value), "\u00b5s")
                                     : figures::shown(number_of(value) / 1000.0, "ms");
  try {
    if (first == ">" || first == "<" || first == "=")
      return compared(value, first[0], std::stod(std::string(rest))) ? "true" : "";
    return as_number(value, first, rest);
  } catch (const std::exception&) {  // a format that is none
    return "?";
  }
}

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

}  // namespace palpate::evaluation::report
