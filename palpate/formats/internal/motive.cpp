// Takes of OptiTrack Motive, exported as CSV: rigid bodies side by side, each with a quaternion X Y Z W and a place X Y Z.
//
// The first line is a list of keys and values ("Length Units,Meters"). Lines of Type, Name, ID and of Rotation or Position say
// above each column what it is; the line of axes begins with "Frame". Frames in which a body was not seen have empty cells.
// Y is up in Motive's own frame, which is kept. Source: OptiTrack documentation, "Data Export: CSV".
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "palpate/core/csv.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/internal/pose_numbers.h"
#include "palpate/formats/internal/text_table.h"

namespace palpate::formats {
namespace {

using MotiveCells = std::vector<std::string_view>;

struct MotiveHeader {
  MotiveCells about;  // keys and values
  MotiveCells type, name, quantity, axes;
  std::string_view rows;  // what follows
  int line = 0;           // of the axes
};

// Nothing where the line of axes does not come.
std::optional<MotiveHeader> motive_header(std::string_view content) {
  constexpr int kMostLines = 12;
  MotiveHeader header;
  for (header.line = 1; header.line <= kMostLines; ++header.line) {
    const auto raw = next_line(content);
    if (!raw) return std::nullopt;
    auto cells = cells_of(*raw, ',', kMostTableColumns);
    if (header.line == 1) header.about = cells;
    if (cells.size() < 3) continue;
    if (cells[0] == "Frame") {
      header.axes = std::move(cells);
      header.rows = content;
      return header;
    }
    if (cells[1] == "Type") header.type = cells;
    if (cells[1] == "Name") header.name = cells;
    if (cells[2] == "Rotation" || cells[2] == "Position") header.quantity = std::move(cells);
  }
  return std::nullopt;
}

std::string_view said(const MotiveHeader& header, std::string_view key) {
  const auto at = std::find(header.about.begin(), header.about.end(), key);
  return at == header.about.end() || at + 1 == header.about.end() ? std::string_view() : at[1];
}

std::string_view motive_cell(const MotiveCells& cells, std::size_t at) {
  return at < cells.size() ? cells[at] : std::string_view();
}

// Columns of x y z and qw qx qy qz of each rigid body, by its name.
using MotiveColumns = std::array<std::optional<std::size_t>, 7>;
std::map<std::string, MotiveColumns> bodies_of(const MotiveHeader& header) {
  std::map<std::string, MotiveColumns> bodies;
  for (std::size_t i = 2; i < header.axes.size(); ++i) {
    if (motive_cell(header.type, i) != "Rigid Body") continue;
    const auto axis = header.axes[i], quantity = motive_cell(header.quantity, i);
    const std::string_view letters = quantity == "Position" ? "XYZ" : quantity == "Rotation" ? "WXYZ" : "";
    const auto at = axis.size() == 1 ? letters.find(axis) : std::string_view::npos;
    if (at == std::string_view::npos) continue;
    bodies[std::string(motive_cell(header.name, i))][at + (quantity == "Rotation" ? 3 : 0)] = i;
  }
  std::erase_if(bodies, [](const auto& body) {
    return std::any_of(body.second.begin(), body.second.end(), [](const auto& column) { return !column; });
  });
  return bodies;
}

Expected<MotiveColumns> chosen_rigid_body(const Source& source,
                                          const std::map<std::string, MotiveColumns>& bodies) {
  if (const auto named = bodies.find(source.options.tool); named != bodies.end()) return named->second;
  if (source.options.tool.empty() && bodies.size() == 1) return bodies.begin()->second;
  std::string names;
  for (const auto& [name, columns] : bodies) names += (names.empty() ? "" : ", ") + excerpt(name, 60);
  return wrong_use("{}: is a take of OptiTrack Motive with the rigid bodies {}; name one with --tool",
                   source.name, excerpt(names, 400));
}

Expected<double> unit_of_take(const Source& source, const MotiveHeader& header) {
  const auto unit = said(header, "Length Units");
  if (unit == "Meters") return 1.0;
  if (unit == "Centimeters") return 0.01;
  if (unit == "Millimeters") return 0.001;
  return wrong_use("{}: Length Units are '{}'; Meters, Centimeters or Millimeters are expected", source.name,
                   excerpt(unit, 40));
}

}  // namespace

bool is_motive(std::string_view content) {
  return content.starts_with("Format Version,") &&
         content.substr(0, 2000).find("Take Name") != std::string_view::npos;
}

Expected<Content> read_motive(const Source& source) {
  const auto header = motive_header(source.content);
  if (!header)
    return wrong_use(
        "{}: is a take of OptiTrack Motive without its line of axes (Frame, Time (Seconds), X, ...); export "
        "it again",
        source.name);
  const auto bodies = bodies_of(*header);
  if (said(*header, "Rotation Type") != "Quaternion" || bodies.empty())
    return wrong_use(
        "{}: is a take of OptiTrack Motive without a rigid body's quaternion and place; export rigid bodies "
        "with the rotation "
        "type Quaternion",
        source.name);
  const auto body = chosen_rigid_body(source, bodies);
  if (!body) return tl::unexpected(body.error());
  const auto scale = unit_of_take(source, *header);
  if (!scale) return tl::unexpected(scale.error());
  Poses poses;
  poses.has_time = true;
  std::string_view content = header->rows;
  for (int line = header->line + 1;; ++line) {
    const auto raw = next_line(content);
    if (!raw) break;
    if (trimmed(*raw).empty()) continue;
    const auto where = fmt::format("{}:{}", source.name, line);
    const auto cells = cells_of(*raw, ',', kMostTableColumns);
    PoseNumbers numbers;
    for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = number_of(motive_cell(cells, *(*body)[k]));
    if (is_hidden(numbers)) {
      ++poses.left_out;
      continue;
    }
    const auto time = number_of(motive_cell(cells, 1));
    if (!is_whole(numbers) || !time || !(std::abs(*time) <= kLatestTime))
      return wrong_use(
          "{}: a part of the pose or its time is missing; all of it, or nothing where the body was hidden, "
          "is expected",
          where);
    auto pose = pose_of(numbers, *scale, where);
    if (!pose) return tl::unexpected(pose.error());
    pose->time_s = *time;
    poses.poses.push_back(*pose);
  }
  return Content{"a take of OptiTrack Motive", "the body in Motive's frame (Y up), s and m", poses};
}

}  // namespace palpate::formats
