// What an application lets people set: named values with their unit, range and meaning, in sections of a
// file.
//
// A schema is data. Who reads files, shows help or checks what came over the network goes by it and knows no
// application. Values are kept as a file has them, in the unit that the key names, and are read in SI: the
// same number is written again, and two sides that read the same text have the same value to the last bit.
// Values, copied freely; any thread. Errors: std::out_of_range for a name that the schema lacks,
// std::invalid_argument for a value of another kind (wrong use of code); what files and peers say is checked
// by check().
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/toml.h"
#include "palpate/math/so3.h"
#include "palpate/scene/payload.h"

namespace palpate::scene {

enum class SettingKind : std::uint8_t {
  number,
  numbers,  // as many as the initial value has
  text,
  choice,  // one of the field's choices
  file,    // a path; in a file it is named as seen from that file
};

using SettingValue = std::variant<std::vector<double>, std::string>;

struct SettingField {
  std::string section, key;  // [section] key = value; the key ends in the unit: mass_kg
  SettingKind kind = SettingKind::number;
  SettingValue initial{};              // in the file's unit, as range is
  double unit = 1.0;                   // what one in the file is in SI
  NumberRange range{};                 // of each number
  std::vector<std::string> choices{};  // of a choice
  std::string help{};                  // a phrase for a person

  std::string name() const { return section + "." + key; }  // as settings are called: "ball.mass_kg"
};

// Fields of one number, of several and of words to choose from.
SettingField number_field(std::string section, std::string key, double initial, NumberRange range,
                          std::string help, double unit = 1.0);
SettingField numbers_field(std::string section, std::string key, std::vector<double> initial,
                           NumberRange range, std::string help, double unit = 1.0);
SettingField choice_field(std::string section, std::string key, std::string initial,
                          std::vector<std::string> choices, std::string help);

struct Setting {
  SettingField field;
  SettingValue value;
};

// What is wrong with a setting, in words that follow its name: "is 3, at most 2 is expected".
struct SettingComplaint {
  std::string section, key, message;
};

// Whether a value is of the field's kind: a text, or as many numbers as the initial value has.
bool fits(const SettingField& field, const SettingValue& value);

class SettingValues;

struct SettingSchema {
  std::vector<SettingField> fields;
  // What no single value shows; the first complaint counts. May be empty.
  std::function<std::vector<SettingComplaint>(const SettingValues&)> relations{};
  std::uint32_t version = 1;  // of the payload: another one where a field changes its meaning
};

// The values of a schema's fields, at first the initial ones; of several schemas, where they are added.
class SettingValues {
 public:
  SettingValues() = default;
  explicit SettingValues(const SettingSchema& schema) { add(schema); }
  // Throws std::invalid_argument for a field that is there already.
  void add(const SettingSchema& schema);

  bool has(std::string_view name) const;
  double number(std::string_view name) const;                // SI
  std::vector<double> numbers(std::string_view name) const;  // SI
  std::array<double, 2> range(std::string_view name) const;  // SI; of a field of two numbers
  Vector3 vector(std::string_view name) const;               // SI; of a field of three
  const std::string& text(std::string_view name) const;      // of texts, choices, files

  // In the file's unit. set() takes what fits the field's kind; whether it is in range says check().
  void set(std::string_view name, SettingValue value);
  void set(std::string_view name, double value) { set(name, SettingValue(std::vector<double>{value})); }
  // The values of `other` for the fields that are here as well.
  void take(const SettingValues& other);

  const Setting& at(std::string_view name) const { return settings_[index_of(name)]; }
  std::span<const Setting> all() const { return settings_; }  // in the schema's order

 private:
  std::size_t index_of(std::string_view name) const;
  const std::vector<double>& list(std::string_view name, std::size_t count) const;

  std::vector<Setting> settings_;
};

// Wrong use: names the setting, its value, and what is expected.
Expected<void> check(const SettingSchema& schema, const SettingValues& values);

// Values on their way to another process, and back: JSON text, a table for each section, every number with
// the digits that give the same double again.
Payload to_payload(const SettingSchema& schema, const SettingValues& values);
// Refused: another version, a key too many or too few, a value out of range. An empty payload has the initial
// values.
Expected<SettingValues> from_payload(const SettingSchema& schema, const Payload& payload);

}  // namespace palpate::scene
