#include "palpate/device/transform_sequence.h"

#include <array>
#include <charconv>
#include <cmath>
#include <deque>
#include <map>
#include <set>

#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::device {
namespace {

struct Frame {
  double time_s = 0.0;
  int line = 0;
  std::map<std::string, std::array<double, 16>, std::less<>> matrices;  // by name, without "Transform"
  std::set<std::string, std::less<>> invalid;
};

struct Edge {  // maps `from` coordinates to `to` coordinates
  std::string from, to;
};

// "StylusToTracker" -> Stylus, Tracker. The first "To" inside, followed by a capital, separates.
std::optional<Edge> split_name(std::string_view name) {
  for (std::size_t at = name.find("To", 1); at != std::string_view::npos; at = name.find("To", at + 1))
    if (at + 2 < name.size() && name[at + 2] >= 'A' && name[at + 2] <= 'Z')
      return Edge{std::string(name.substr(0, at)), std::string(name.substr(at + 2))};
  return std::nullopt;
}

struct Step {
  std::string name;
  bool inverted;
};

// Shortest chain of the file's transforms, forwards or inverted, breadth first.
std::optional<std::vector<Step>> find_chain(const std::set<std::string>& names, const Edge& wanted) {
  std::map<std::string, std::vector<Step>> reached{{wanted.from, {}}};
  std::deque<std::string> open{wanted.from};
  while (!open.empty()) {
    const std::string at = open.front();
    open.pop_front();
    if (at == wanted.to) return reached[at];
    for (const auto& name : names) {
      const auto edge = split_name(name);
      if (!edge) continue;
      for (const bool inverted : {false, true}) {
        const auto& from = inverted ? edge->to : edge->from;
        const auto& to = inverted ? edge->from : edge->to;
        if (from != at || reached.contains(to)) continue;
        auto steps = reached[at];
        steps.push_back({name, inverted});
        reached[to] = std::move(steps);
        open.push_back(to);
      }
    }
  }
  return std::nullopt;
}

bool read_numbers(std::string_view text, std::array<double, 16>& m) {
  std::size_t count = 0;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    if (*at == ' ' || *at == '\t' || *at == '\r') {
      ++at;
      continue;
    }
    double value = 0.0;
    const auto [next, code] = std::from_chars(at, end, value);
    if (code != std::errc() || !std::isfinite(value) || count == 16) return false;
    m[count++] = value;
    at = next;
  }
  return count == 16;
}

constexpr std::string_view kTransform = "Transform";
constexpr std::size_t kMostTransforms = 256;  // by name; a chain is looked for among all of them

struct Entry {  // Seq_Frame<number>_<key> = <value>
  int number = 0;
  std::string_view key, value;
};

// The next line that is one, taken off the content's front; none at the end of the text. Counts lines.
std::optional<Entry> next_entry(std::string_view& content, int* lines = nullptr) {
  while (!content.empty()) {
    const auto end = content.find('\n');
    const auto line = content.substr(0, end);
    content.remove_prefix(end == std::string_view::npos ? content.size() : end + 1);
    if (lines != nullptr) ++*lines;
    if (line.substr(0, 15) == "ElementDataFile") return std::nullopt;  // pixels follow
    const std::string_view start = "Seq_Frame";
    if (line.substr(0, start.size()) != start) continue;
    const auto equals = line.find(" = ");
    Entry entry;
    const auto [rest, code] =
        std::from_chars(line.data() + start.size(), line.data() + line.size(), entry.number);
    if (code != std::errc() || equals == std::string_view::npos || rest == line.data() + line.size() ||
        *rest != '_')
      continue;
    entry.key = std::string_view(rest + 1, static_cast<std::size_t>(line.data() + equals - rest - 1));
    entry.value = line.substr(equals + 3);
    while (!entry.value.empty() && (entry.value.back() == ' ' || entry.value.back() == '\r'))
      entry.value.remove_suffix(1);
    return entry;
  }
  return std::nullopt;
}

}  // namespace

bool is_transform_sequence(std::string_view content) {
  return content.substr(0, 10) == "ObjectType" &&
         content.substr(0, 2000).find("NDims") != std::string_view::npos;
}

std::vector<std::string> transform_names(std::string_view content) {
  std::set<std::string> names;
  while (const auto entry = next_entry(content))
    if (entry->key.ends_with(kTransform))
      names.emplace(entry->key.substr(0, entry->key.size() - kTransform.size()));
  return {names.begin(), names.end()};
}

Expected<std::vector<StampedPose>> parse_transform_sequence(std::string_view content,
                                                            const std::string& source,
                                                            const std::string& transform,
                                                            std::size_t* left_out) {
  std::map<int, Frame> frames;
  std::set<std::string> names;
  int line_number = 0;
  while (const auto entry = next_entry(content, &line_number)) {
    const auto& [number, key, value] = *entry;
    Frame& frame = frames[number];
    if (frame.line == 0) frame.line = line_number;
    if (key == "Timestamp") {
      const auto [end_of_time, time_code] =
          std::from_chars(value.data(), value.data() + value.size(), frame.time_s);
      if (time_code != std::errc() || !(std::abs(frame.time_s) <= kLatestTime))
        return wrong_use("{}:{}: {} is '{}'; a time in seconds is expected", source, line_number,
                         excerpt(key), excerpt(value));
    } else if (key.ends_with("TransformStatus")) {
      if (value != "OK") frame.invalid.emplace(key.substr(0, key.size() - 15));
    } else if (key.ends_with("Transform")) {
      const auto name = std::string(key.substr(0, key.size() - 9));
      if (!read_numbers(value, frame.matrices[name]))
        return wrong_use("{}:{}: {} is no matrix; 16 finite numbers are expected", source, line_number,
                         excerpt(key));
      names.insert(name);
      if (names.size() > kMostTransforms)
        return wrong_use("{}:{}: a recording of at most {} transforms is expected", source, line_number,
                         kMostTransforms);
    }
  }
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "" : ", ") + excerpt(name);
  list = excerpt(list, 160);
  if (names.empty())
    return wrong_use("{}: holds no transforms; lines Seq_Frame0000_AToBTransform = 16 numbers are expected",
                     source);
  if (transform.empty() && names.size() > 1)
    return wrong_use("{}: holds several transforms ({}); say which with --transform AToB", source, list);
  const std::string& name_wanted = transform.empty() ? *names.begin() : transform;
  const auto wanted = split_name(name_wanted);
  if (!wanted)
    return wrong_use("{}: the transform '{}' has no name of the form AToB, which is expected", source,
                     excerpt(name_wanted));
  const auto chain = find_chain(names, *wanted);
  if (!chain || chain->empty())
    return wrong_use("{}: {} cannot be composed from the transforms there are ({}); choose one that can",
                     source, excerpt(transform), list);

  std::vector<StampedPose> poses;
  for (const auto& [number, frame] : frames) {
    StampedPose pose;
    bool usable = true;
    for (const auto& [name, inverted] : *chain) {
      const auto matrix = frame.matrices.find(name);
      if (matrix == frame.matrices.end() || frame.invalid.contains(name)) {
        usable = false;
        break;
      }
      auto step =
          pose_from_matrix(std::span(matrix->second).first(12), 1e-3,
                           fmt::format("{}:{}: frame {}, {}", source, frame.line, number, excerpt(name)));
      if (!step) return tl::unexpected(step.error());
      if (inverted) {
        step->rotation = step->rotation.conjugate();
        step->translation = -(step->rotation * step->translation);
      }
      pose.translation = step->rotation * pose.translation + step->translation;
      pose.rotation = (step->rotation * pose.rotation).normalized();
    }
    if (!usable) continue;
    pose.time_s = frame.time_s;
    poses.push_back(pose);
  }
  if (left_out != nullptr) *left_out = frames.size() - poses.size();
  if (poses.empty())
    return refused("{}: no frame has all transforms of {} with status OK; record with both tools in sight",
                   source, excerpt(name_wanted));
  return poses;
}

}  // namespace palpate::device
