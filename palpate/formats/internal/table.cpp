// Tables with a header: which columns they have says table_header.h; here are their rows.
#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/core/csv.h"
#include "palpate/core/file_form.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/internal/pose_numbers.h"
#include "palpate/formats/internal/table_header.h"
#include "palpate/formats/internal/text_table.h"
#include "palpate/math/so3.h"

namespace palpate::formats {
namespace {

constexpr int kLinesBeforeTheHeader = 30;

using Cells = std::vector<std::string_view>;

struct FoundHeader {
  TableHeader header;
  std::string_view rows;  // what follows
  int line = 0;           // the header's number
};

std::optional<FoundHeader> find_header(std::string_view content, char separator) {
  for (int line = 1; line <= kLinesBeforeTheHeader; ++line) {
    const auto raw = next_line(content);
    if (!raw) return std::nullopt;
    auto text = trimmed(*raw);
    if (separator == ' ' && text.starts_with('#')) text = trimmed(text.substr(1));
    if (auto header = understand_header(cells_of(text, separator, kMostTableColumns)))
      return FoundHeader{std::move(*header), content, line};
  }
  return std::nullopt;
}

// What stands at a position; empty where the row ends before.
std::string_view cell_at(const Cells& cells, std::size_t at) {
  return at < cells.size() ? cells[at] : std::string_view();
}

std::string same_letters(std::string_view word) {
  std::string letters;
  for (const char c : word)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return letters;
}

bool says_seen(std::string_view state) {
  const auto word = same_letters(state);
  return word == "ok" || word == "enabled" || word == "valid" || word == "tracked" || word == "visible";
}

// Rz Ry Rx, degrees: R = Rz Ry Rx.
void turn_angles(PoseNumbers& n) {
  if (!is_whole(n)) return;
  const auto rad = [](double degrees) { return degrees / kDegreesPerRadian; };
  const Quaternion q(Eigen::AngleAxisd(rad(*n[3]), Vector3::UnitZ()) *
                     Eigen::AngleAxisd(rad(*n[4]), Vector3::UnitY()) *
                     Eigen::AngleAxisd(rad(*n[5]), Vector3::UnitX()));
  n[3] = q.w(), n[4] = q.x(), n[5] = q.y(), n[6] = q.z();
}

Expected<BodyColumns> chosen_body(const Source& source, const TableHeader& header) {
  const auto& bodies = header.bodies;
  const auto name_of = [&](std::size_t i) {
    return bodies[i].name.empty() ? std::to_string(i + 1) : excerpt(bodies[i].name, 60);
  };
  std::string names;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!source.options.tool.empty() && name_of(i) == source.options.tool) return bodies[i];
    names += (i > 0 ? ", " : "") + name_of(i);
  }
  if (names.size() > 400) names = names.substr(0, 400) + "...";
  if (!source.options.tool.empty() && bodies.size() == 1 && bodies.front().name.empty())
    return wrong_use("{}: is {} of one body without a name; remove --tool {}", source.name, header.form,
                     excerpt(source.options.tool, 40));
  if (!source.options.tool.empty())
    return wrong_use("{}: is {} without a tool '{}'; it has {}", source.name, header.form,
                     excerpt(source.options.tool), names);
  if (bodies.size() == 1) return bodies.front();
  return wrong_use(
      "{}: is {} of {} tools side by side ({}); one of them is needed: palpate convert --tool NAME",
      source.name, header.form, bodies.size(), names);
}

std::optional<double> time_of(const TimeColumns& time, const Cells& cells, bool decimal_commas) {
  const auto value = [&](std::size_t k) { return number_of(cell_at(cells, time.at[k]), decimal_commas); };
  const auto first = value(0);
  if (!first) return std::nullopt;
  switch (time.form) {
    case TimeForm::none:
      return std::nullopt;
    case TimeForm::seconds:
      return first;
    case TimeForm::milliseconds:
      return *first * 1e-3;
    case TimeForm::microseconds:
      return *first * 1e-6;
    case TimeForm::nanoseconds:
      // Written with a point it is seconds, whatever the column is called.
      return cell_at(cells, time.at[0]).find('.') == std::string_view::npos ? *first * 1e-9 : *first;
    case TimeForm::seconds_and_nanoseconds:
      if (const auto ns = value(1)) return *first + *ns * 1e-9;
      return std::nullopt;
    case TimeForm::time_of_day:
      if (const auto m = value(1), s = value(2), ms = value(3); m && s && ms)
        return *first * 3600.0 + *m * 60.0 + *s + *ms * 1e-3;
      return std::nullopt;
  }
  return std::nullopt;
}

// Hands each row's cells over, with its place for messages, until one is refused.
template <typename Take>
Expected<void> for_each_row(const Source& source, const FoundHeader& found, char separator,
                            const Take& take) {
  std::string_view content = found.rows;
  std::size_t rows = 0;
  for (int line = found.line + 1;; ++line) {
    const auto raw = next_line(content);
    if (!raw) return {};
    const auto text = trimmed(*raw);
    if (text.empty() || text.front() == '#') continue;
    if (++rows > kMostTableRows)
      return wrong_use("{}:{}: a table of at most {} rows is expected; split it", source.name, line,
                       kMostTableRows);
    if (auto taken =
            take(cells_of(text, separator, kMostTableColumns), fmt::format("{}:{}", source.name, line));
        !taken)
      return taken;
  }
}

Expected<double> unit_of(const Source& source, const TableHeader& header, double known) {
  const double scale = known > 0 ? known : source.options.metres_per_unit;
  if (scale > 0) return scale;
  return wrong_use(
      "{}: is {}; a unit is needed: palpate convert --unit mm, or m; or columns x_mm, y_mm, z_mm (or _m) in "
      "its header",
      source.name, header.form);
}

Expected<Content> read_bodies(const Source& source, const FoundHeader& found, Separation separation) {
  const auto body = chosen_body(source, found.header);
  if (!body) return tl::unexpected(body.error());
  const auto scale = unit_of(source, found.header, body->metres_per_unit);
  if (!scale) return tl::unexpected(scale.error());
  const auto& time = found.header.time;
  Poses poses;
  poses.has_time = time.form != TimeForm::none;
  std::size_t row = 0;
  auto read = for_each_row(
      source, found, separation.separator,
      [&](const Cells& cells, const std::string& where) -> Expected<void> {
        PoseNumbers numbers;
        for (std::size_t k = 0; k < numbers.size(); ++k)
          numbers[k] = number_of(cell_at(cells, body->at[k]), separation.decimal_commas);
        const auto number = row++;
        if (body->state && !says_seen(cell_at(cells, *body->state))) {
          ++poses.left_out;
          return {};
        }
        for (std::size_t k = 0; k < numbers.size(); ++k)
          if (const auto cell = cell_at(cells, body->at[k]);
              !numbers[k] && !is_missing(cell) && same_letters(cell) != "missing")
            return wrong_use("{}: '{}' is no finite number; {} is expected", where, excerpt(cell, 24),
                             found.header.told);
        if (body->euler_degrees) turn_angles(numbers);
        if (is_hidden(numbers)) {
          ++poses.left_out;
          return {};
        }
        if (!is_whole(numbers))
          return wrong_use(
              "{}: a part of the pose is missing; all of it, or nothing where the body was hidden, is "
              "expected",
              where);
        auto pose = pose_of(numbers, *scale, where);
        if (!pose) return tl::unexpected(pose.error());
        if (poses.poses.empty() && poses.has_time && is_missing(cell_at(cells, time.at[0])))
          poses.has_time = false;
        const auto stamp = poses.has_time ? time_of(time, cells, separation.decimal_commas) : std::nullopt;
        if (poses.has_time && !(stamp && std::abs(*stamp) <= kLatestTime))
          return wrong_use("{}: the time is no number of seconds", where);
        pose->time_s = stamp.value_or(static_cast<double>(number));
        poses.poses.push_back(*pose);
        return {};
      });
  if (!read) return tl::unexpected(read.error());
  return Content{found.header.form + (body->name.empty() ? "" : ", " + excerpt(body->name, 60)),
                 found.header.told, poses};
}

Expected<Content> read_places(const Source& source, const FoundHeader& found, Separation separation) {
  const auto& columns = *found.header.points;
  const auto scale = unit_of(source, found.header, columns.metres_per_unit);
  if (!scale) return tl::unexpected(scale.error());
  Points points;
  auto read = for_each_row(source, found, separation.separator,
                           [&](const Cells& cells, const std::string& where) -> Expected<void> {
                             Vector3 place;
                             for (std::size_t k = 0; k < 3; ++k) {
                               const auto number =
                                   number_of(cell_at(cells, columns.at[k]), separation.decimal_commas);
                               if (!number || !(std::abs(*number * *scale) <= kFarthestPlace))
                                 return wrong_use("{}: '{}' is no place within {:g} m", where,
                                                  excerpt(cell_at(cells, columns.at[k]), 24), kFarthestPlace);
                               place(static_cast<Eigen::Index>(k)) = *scale * *number;
                             }
                             points.places.push_back(place);
                             if (columns.label)
                               points.labels.emplace_back(excerpt(cell_at(cells, *columns.label), 120));
                             return {};
                           });
  if (!read) return tl::unexpected(read.error());
  if (points.places.empty()) return wrong_use("{}: is {} without a row", source.name, found.header.form);
  const bool timed = found.header.time.form != TimeForm::none;
  return Content{found.header.form, found.header.told + (timed ? "; their times are left out" : ""), points};
}

// The header of an arm's samples in its first line, of which some have nothing else that is known here.
bool names_joints(std::string_view content) {
  const auto line = next_line(content);
  return line && line->find("joint_1") != std::string_view::npos;
}

}  // namespace

bool is_table(std::string_view content) {
  return find_header(content, separation_of(content).separator).has_value();
}

bool has_own_columns(std::string_view content) {
  const auto found = find_header(content, separation_of(content).separator);
  return found && found->header.own;
}

bool is_own_table(std::string_view content) {
  return separation_of(content).separator == ',' && has_own_columns(content);
}

std::optional<std::string> with_commas(std::string_view content) {
  content = without_byte_order_mark(content);
  const auto [separator, decimal_commas] = separation_of(content);
  const auto found = find_header(content, separator);
  if (separator == ',' || !(found || names_joints(content))) return std::nullopt;
  const int header_line = found ? found->line : 1;
  std::string table;
  int number = 0;
  while (const auto raw = next_line(content)) {
    auto text = separator == ' ' ? trimmed(*raw) : *raw;  // a tab at its end begins an empty cell
    if (++number == header_line && text.starts_with('#')) text.remove_prefix(1);
    if (number >= header_line && !trimmed(text).empty() && text.front() != '#') {
      bool first = true;
      for (const auto cell : cells_of(text, separator, kMostTableColumns)) {
        if (!std::exchange(first, false)) table += ',';
        const auto begin = table.size();
        table += cell;
        if (cell.find(',') == std::string_view::npos) continue;
        if (!decimal_commas || !number_of(cell, true)) return std::nullopt;
        std::replace(table.begin() + static_cast<std::ptrdiff_t>(begin), table.end(), ',', '.');
      }
    }
    table += '\n';
  }
  return table;
}

Expected<Content> read_table(const Source& source) {
  const Separation separation = separation_of(source.content);
  const auto found = find_header(source.content, separation.separator);
  if (!found)
    return wrong_use(
        "{}: no line of names is known here: those of a pose's columns, or of a point's, are expected",
        source.name);
  if (!found->header.cannot.empty())
    return wrong_use("{}:{}: {}; correct the header: x_mm,y_mm,z_mm,qw,qx,qy,qz, or x_mm,y_mm,z_mm",
                     source.name, found->line, found->header.cannot);
  if (!found->header.bodies.empty()) return read_bodies(source, *found, separation);
  return read_places(source, *found, separation);
}

}  // namespace palpate::formats
