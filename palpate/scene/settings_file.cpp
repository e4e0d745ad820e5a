#include "palpate/scene/settings_file.h"

#include <fmt/format.h>

#include <algorithm>

namespace palpate::scene {
namespace {

SettingValue value_from(const TomlTable& table, const SettingField& field) {
  switch (field.kind) {
    case SettingKind::number:
      return std::vector<double>{table.number(field.key, field.range)};
    case SettingKind::numbers:
      return table.numbers(field.key, std::get<std::vector<double>>(field.initial).size(), field.range);
    case SettingKind::choice:
      return table.choice(field.key, field.choices);
    case SettingKind::text:
    case SettingKind::file:
      break;
  }
  return table.text(field.key);
}

std::string text_of(const Setting& setting) {
  const auto* numbers = std::get_if<std::vector<double>>(&setting.value);
  if (numbers == nullptr) return toml_quoted(std::get<std::string>(setting.value));
  if (setting.field.kind == SettingKind::number) return toml_number(numbers->front());
  std::string all;
  for (const double x : *numbers) all += (all.empty() ? "" : ", ") + toml_number(x);
  return "[" + all + "]";
}

}  // namespace

void read_settings(const TomlTable& table, std::string_view section, SettingValues& values) {
  std::vector<SettingField> fields;
  for (const auto& setting : values.all())
    if (setting.field.section == section) fields.push_back(setting.field);
  for (const auto& field : fields) {
    table.expect(field.key);
    if (!table.has(field.key)) continue;
    auto value = value_from(table, field);
    // After a complaint readers return harmless defaults, which need not be of the field's kind.
    if (fits(field, value)) values.set(field.name(), std::move(value));
  }
}

void complain_of_relations(const TomlTable& root, const ApplicationRegistry& applications,
                           const SettingValues& values) {
  for (const auto& complaint : applications.complaints(values))
    root.table(complaint.section).complain(complaint.key, complaint.message);
}

void resolve_files(const std::filesystem::path& folder, SettingValues& values) {
  std::vector<std::string> files;
  for (const auto& setting : values.all())
    if (setting.field.kind == SettingKind::file) files.push_back(setting.field.name());
  for (const auto& name : files) {
    const std::filesystem::path file = values.text(name);
    if (!file.empty() && file.is_relative())
      values.set(name, std::filesystem::absolute(folder / file).lexically_normal().string());
  }
}

Expected<void> read_settings_file(const std::filesystem::path& path, const ApplicationRegistry& applications,
                                  SettingValues& values) {
  const auto root = read_toml(path);
  if (!root) return tl::unexpected(root.error());
  SettingValues read = values;
  for (const auto& section : sections_of(read)) read_settings(root->table(section), section, read);
  if (auto done = root->finish(); !done) return done;
  complain_of_relations(*root, applications, read);
  if (auto done = root->finish(); !done) return done;
  resolve_files(path.parent_path(), read);
  values = std::move(read);
  return {};
}

std::vector<std::string> sections_of(const SettingValues& values) {
  std::vector<std::string> sections;
  for (const auto& setting : values.all())
    if (std::find(sections.begin(), sections.end(), setting.field.section) == sections.end())
      sections.push_back(setting.field.section);
  return sections;
}

std::string settings_text(const SettingValues& values, std::string_view section) {
  std::string text;
  for (const auto& setting : values.all())
    if (setting.field.section == section)
      text += fmt::format("{} = {}\n", setting.field.key, text_of(setting));
  return text;
}

}  // namespace palpate::scene
