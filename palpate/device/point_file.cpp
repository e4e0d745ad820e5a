#include "palpate/device/point_file.h"

#include "palpate/core/file.h"
#include "palpate/core/units.h"

namespace palpate::device {

Expected<PointFile> read_points(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  return parse_points(*content, path.string());
}

Expected<PointFile> parse_points(std::string_view content, std::string source) {
  PointFile file;
  file.source = std::move(source);
  file.hash = content_hash(content);
  const std::vector<std::string> label_columns = {"label",  "name",    "landmark", "point",
                                                  "corner", "segment", "id"};
  CsvOptions csv;
  csv.text_columns = label_columns;
  csv.text_columns.push_back("surface");
  auto table = parse_csv(content, file.source, csv);
  if (!table) return tl::unexpected(table.error());
  if (table->header.empty())
    return wrong_use(
        "{}: has no header line; x_mm,y_mm,z_mm are expected in it (palpate convert --unit mm, or m, "
        "writes it)",
        file.source);
  const bool metres = !table->has("x_mm") && table->has("x_m");
  std::array<std::size_t, 3> at{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto column = table->require(std::string(1, "xyz"[i]) + (metres ? "_m" : "_mm"));
    if (!column) return tl::unexpected(column.error());
    at[i] = *column;
  }
  if (const auto fine = table->require_within({at[0], at[1], at[2]},
                                              (metres ? 1.0 : kMillimetresPerMetre) * kFarthestPlace);
      !fine)
    return tl::unexpected(fine.error());
  const auto weight = table->find("weight");
  constexpr double kLargestWeight = 1e12;
  if (weight)
    if (const auto fine = table->require_within({*weight}, kLargestWeight); !fine)
      return tl::unexpected(fine.error());
  for (std::size_t i = 0; i < table->rows.size(); ++i) {
    const auto& row = table->rows[i];
    file.points.push_back((metres ? 1.0 : 1e-3) * Vector3(row[at[0]], row[at[1]], row[at[2]]));
    if (!weight) continue;
    if (!(row[*weight] >= 0.0))
      return wrong_use("{}:{}: weight is {}, at least 0 is expected", file.source, table->line[i],
                       row[*weight]);
    file.weights.push_back(row[*weight]);
  }
  for (const auto& name : label_columns) {
    const auto column = table->find(name);
    if (!column) continue;
    for (const auto& cells : table->text) file.labels.push_back(cells[*column]);
    break;
  }
  if (file.points.empty())
    return wrong_use("{}: holds a header but no points; at least one row is expected", file.source);
  file.table = std::move(*table);
  return file;
}

}  // namespace palpate::device
