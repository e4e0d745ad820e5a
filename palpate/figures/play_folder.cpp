#include "palpate/figures/play_folder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/figures/limits.h"

namespace palpate::figures {
namespace fs = std::filesystem;

Expected<PlayFolder> PlayFolder::read(const fs::path& folder) {
  PlayFolder play;
  play.folder_ = folder;
  const auto summary = read_file(folder / "summary.json");
  if (!summary) return tl::unexpected(summary.error());
  play.summary_ = Json::parse(*summary, nullptr, false);
  if (!play.summary_.is_object())
    return wrong_use("{}: is not a JSON object", (folder / "summary.json").string());
  if (!fs::is_directory(folder / "raw")) return play;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder / "raw")) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    CsvOptions options;
    options.text_columns = {"*"};
    auto table = read_csv(file, options);
    if (!table) return tl::unexpected(table.error());
    play.tables_.emplace_back(file.filename().string(), std::move(*table));
  }
  return play;
}

const Json* PlayFolder::find(std::string_view path) const { return find_in(summary_, path); }

std::optional<double> PlayFolder::number(std::string_view path) const {
  const Json* value = find(path);
  return value != nullptr && value->is_number() ? std::optional(value->get<double>()) : std::nullopt;
}

std::optional<std::string> PlayFolder::text(std::string_view path) const {
  const Json* value = find(path);
  return value != nullptr && value->is_string() ? std::optional(value->get<std::string>()) : std::nullopt;
}

const CsvTable* PlayFolder::raw(std::string_view name) const {
  for (const auto& [file, table] : tables_) {
    if (file == name) return table.rows.empty() ? nullptr : &table;
  }
  return nullptr;
}

std::string PlayFolder::bytes(std::string_view name) const { return read_file(folder_ / name).value_or(""); }

bool PlayFolder::has(std::string_view name) const { return fs::is_regular_file(folder_ / name); }

std::vector<std::string> PlayFolder::pictures(std::string_view folder) const {
  std::vector<std::string> names;
  if (!fs::is_directory(folder_ / folder)) return names;
  for (const auto& entry : fs::directory_iterator(folder_ / folder)) {
    if (entry.path().extension() == ".png")
      names.push_back((fs::path(folder) / entry.path().filename()).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<double> column(const CsvTable& table, std::string_view name) {
  std::vector<double> values;
  const auto at = table.find(name);
  if (!at) return values;
  values.reserve(table.rows.size());
  for (const auto& row : table.rows) values.push_back(row[*at]);
  return values;
}

bool has_columns(const CsvTable& table, std::initializer_list<std::string_view> names) {
  return std::all_of(names.begin(), names.end(), [&](std::string_view name) { return table.has(name); });
}

std::string shown(std::optional<double> value, std::string_view unit, int digits) {
  if (!value || !std::isfinite(*value)) return "\u2014";
  const double size = std::abs(*value);
  const int before = size < 1.0 ? 0 : static_cast<int>(std::floor(std::log10(size))) + 1;
  std::string number = fmt::format("{:.{}f}", *value, std::max(0, digits - before));
  if (number.find('.') != std::string::npos) {
    number.erase(number.find_last_not_of('0') + 1);
    if (number.back() == '.') number.pop_back();
  }
  if (unit.empty()) return number;
  return number + (unit == "\u00b0" ? "" : "\u00a0") + std::string(unit);
}

}  // namespace palpate::figures
