#include "palpate/scene/setting_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "palpate/core/nearest.h"
#include "palpate/core/text.h"

namespace palpate::scene {

Expected<SettingValue> value_of_text(const SettingField& field, std::string_view text,
                                     std::string_view called) {
  if (field.kind != SettingKind::number && field.kind != SettingKind::numbers)
    return SettingValue(std::string(text));
  std::vector<double> numbers;
  for (std::string_view rest = text;;) {
    const std::string_view part = rest.substr(0, rest.find(','));
    const std::string_view digits = part.starts_with('+') ? part.substr(1) : part;
    double number = 0.0;
    const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (read.ec != std::errc() || read.ptr != digits.data() + digits.size())
      return wrong_use("{} {}: {} is expected", called, excerpt(text),
                       field.kind == SettingKind::number ? "a number" : "a list of numbers with commas");
    numbers.push_back(number);
    if (part.size() == rest.size()) break;
    rest.remove_prefix(part.size() + 1);
  }
  SettingValue value(numbers);
  if (!fits(field, value))
    return wrong_use("{} {}: {} numbers are expected", called, excerpt(text),
                     std::get<std::vector<double>>(field.initial).size());
  return value;
}

Expected<void> set_by_text(const SettingSchema& schema, std::string_view said, SettingValues& values) {
  const std::size_t equals = said.find('=');
  const std::string name(said.substr(0, equals));
  if (equals == std::string_view::npos)
    return wrong_use("{}: NAME=VALUE is expected, such as {}=...", excerpt(name),
                     schema.fields.empty() ? "section.key" : schema.fields.front().name());
  const auto field = std::find_if(schema.fields.begin(), schema.fields.end(),
                                  [&name](const SettingField& one) { return one.name() == name; });
  if (field == schema.fields.end()) {
    std::vector<std::string> known;
    for (const auto& one : schema.fields) known.push_back(one.name());
    const auto meant = nearest(name, known);
    if (!meant.empty()) return wrong_use("{}: no such setting; did you mean {}?", excerpt(name), meant);
    return wrong_use("{}: no such setting; there are {}", excerpt(name), fmt::join(known, ", "));
  }
  auto value = value_of_text(*field, said.substr(equals + 1), name + ":");
  if (!value) return tl::unexpected(value.error());
  values.set(name, std::move(*value));
  return {};
}

}  // namespace palpate::scene
