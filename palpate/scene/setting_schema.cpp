#include "palpate/scene/setting_schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "palpate/core/json.h"
#include "palpate/core/text.h"

namespace palpate::scene {
namespace {

bool is_numeric(const SettingField& field) {
  return field.kind == SettingKind::number || field.kind == SettingKind::numbers;
}

std::size_t count_of(const SettingValue& value) {
  const auto* numbers = std::get_if<std::vector<double>>(&value);
  return numbers == nullptr ? 0 : numbers->size();
}

Expected<void> check(const SettingField& field, const SettingValue& value) {
  if (const auto* numbers = std::get_if<std::vector<double>>(&value)) {
    for (const double x : *numbers)
      if (!std::isfinite(x) || x < field.range.low || x > field.range.high)
        return wrong_use("{}: is {}; {:g} to {:g} is expected", field.name(), x, field.range.low,
                         field.range.high);
    return {};
  }
  const auto& text = std::get<std::string>(value);
  if (field.kind == SettingKind::choice &&
      std::find(field.choices.begin(), field.choices.end(), text) == field.choices.end())
    return wrong_use("{}: is {}; one of {} is expected", field.name(), excerpt(text),
                     fmt::join(field.choices, ", "));
  return {};
}

Expected<SettingValue> value_from(const SettingField& field, const Json& json) {
  SettingValue value;
  if (json.is_string()) value = json.get<std::string>();
  if (json.is_number()) value = std::vector<double>{json.get<double>()};
  if (json.is_array()) {
    std::vector<double> numbers;
    for (const auto& x : json)
      if (x.is_number()) numbers.push_back(x.get<double>());
    if (numbers.size() == json.size()) value = std::move(numbers);
  }
  if (!fits(field, value)) return refused("{}: is of another kind than is expected", field.name());
  return value;
}

}  // namespace

SettingField number_field(std::string section, std::string key, double initial, NumberRange range,
                          std::string help, double unit) {
  SettingField field =
      numbers_field(std::move(section), std::move(key), {initial}, range, std::move(help), unit);
  field.kind = SettingKind::number;
  return field;
}

SettingField numbers_field(std::string section, std::string key, std::vector<double> initial,
                           NumberRange range, std::string help, double unit) {
  return {.section = std::move(section),
          .key = std::move(key),
          .kind = SettingKind::numbers,
          .initial = std::move(initial),
          .unit = unit,
          .range = range,
          .help = std::move(help)};
}

SettingField choice_field(std::string section, std::string key, std::string initial,
                          std::vector<std::string> choices, std::string help) {
  return {.section = std::move(section),
          .key = std::move(key),
          .kind = SettingKind::choice,
          .initial = std::move(initial),
          .choices = std::move(choices),
          .help = std::move(help)};
}

bool fits(const SettingField& field, const SettingValue& value) {
  return std::holds_alternative<std::vector<double>>(value) == is_numeric(field) &&
         count_of(value) == count_of(field.initial);
}

void SettingValues::add(const SettingSchema& schema) {
  for (const auto& field : schema.fields) {
    if (has(field.name()))
      throw std::invalid_argument(fmt::format("setting {}: two applications claim it", field.name()));
    settings_.push_back({field, field.initial});
  }
}

bool SettingValues::has(std::string_view name) const {
  return std::any_of(settings_.begin(), settings_.end(),
                     [&](const Setting& setting) { return setting.field.name() == name; });
}

std::size_t SettingValues::index_of(std::string_view name) const {
  for (std::size_t i = 0; i < settings_.size(); ++i)
    if (settings_[i].field.name() == name) return i;
  throw std::out_of_range(fmt::format("setting {}: there is none of that name", name));
}

const std::vector<double>& SettingValues::list(std::string_view name, std::size_t count) const {
  const auto* numbers = std::get_if<std::vector<double>>(&at(name).value);
  if (numbers == nullptr || (count != 0 && numbers->size() != count))
    throw std::invalid_argument(fmt::format("setting {}: is no list of {} numbers", name, count));
  return *numbers;
}

double SettingValues::number(std::string_view name) const {
  return list(name, 1).front() * at(name).field.unit;
}

std::vector<double> SettingValues::numbers(std::string_view name) const {
  std::vector<double> values = list(name, 0);
  for (double& x : values) x *= at(name).field.unit;
  return values;
}

std::array<double, 2> SettingValues::range(std::string_view name) const {
  const auto& x = list(name, 2);
  const double unit = at(name).field.unit;
  return {x[0] * unit, x[1] * unit};
}

Vector3 SettingValues::vector(std::string_view name) const {
  const auto& x = list(name, 3);
  return Vector3(x[0], x[1], x[2]) * at(name).field.unit;
}

const std::string& SettingValues::text(std::string_view name) const {
  const auto* text = std::get_if<std::string>(&at(name).value);
  if (text == nullptr) throw std::invalid_argument(fmt::format("setting {}: is no text", name));
  return *text;
}

void SettingValues::set(std::string_view name, SettingValue value) {
  Setting& setting = settings_[index_of(name)];
  if (!fits(setting.field, value))
    throw std::invalid_argument(fmt::format("setting {}: is of another kind", name));
  setting.value = std::move(value);
}

void SettingValues::take(const SettingValues& other) {
  for (auto& setting : settings_)
    if (const std::string name = setting.field.name(); other.has(name)) set(name, other.at(name).value);
}

Expected<void> check(const SettingSchema& schema, const SettingValues& values) {
  for (const auto& setting : values.all())
    if (auto fine = check(setting.field, setting.value); !fine) return fine;
  if (!schema.relations) return {};
  for (const auto& complaint : schema.relations(values))
    return wrong_use("{}.{}: {}", complaint.section, complaint.key, complaint.message);
  return {};
}

Payload to_payload(const SettingSchema& schema, const SettingValues& values) {
  Json json = Json::object();
  for (const auto& field : schema.fields) {
    Json& to = json[field.section][field.key];
    const auto& value = values.at(field.name()).value;
    if (const auto* numbers = std::get_if<std::vector<double>>(&value)) {
      to = field.kind == SettingKind::number ? Json(numbers->front()) : Json(*numbers);
    } else {
      to = std::get<std::string>(value);
    }
  }
  return {schema.version, json.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

Expected<SettingValues> from_payload(const SettingSchema& schema, const Payload& payload) {
  SettingValues values(schema);
  if (payload == Payload{}) return values;
  if (payload.version != schema.version)
    return refused("its settings are of version {}, this side knows {}; use the same release on both",
                   payload.version, schema.version);
  if (payload.bytes.size() > kMaxPayloadBytes)
    return refused("its settings have {} bytes, at most {} are expected", payload.bytes.size(),
                   kMaxPayloadBytes);
  const Json json = Json::parse(payload.bytes, nullptr, false);
  if (!json.is_object()) return refused("its settings are {}, JSON is expected", excerpt(payload.bytes));
  std::size_t known = 0, there = 0;
  for (const auto& [section, table] : json.items()) there += table.is_object() ? table.size() : 1;
  for (const auto& field : schema.fields) {
    if (!json.contains(field.section) || !json[field.section].is_object() ||
        !json[field.section].contains(field.key))
      return refused("{}: is not among its settings, where it is expected", field.name());
    auto value = value_from(field, json[field.section][field.key]);
    if (!value) return tl::unexpected(value.error());
    values.set(field.name(), std::move(*value));
    ++known;
  }
  if (there != known) return refused("its settings are {}, {} are expected", counted(there, "value"), known);
  if (auto fine = check(schema, values); !fine) return refused("{}", fine.error().message);
  return values;
}

}  // namespace palpate::scene
