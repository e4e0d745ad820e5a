#include "palpate/rig/internal/rig_forces.h"

#include <fmt/format.h>

#include <ctime>

#include "palpate/core/units.h"
#include "palpate/rig/internal/number_text.h"

namespace palpate::rig {
namespace {

constexpr NumberRange kTurnDeg{-720.0, 720.0}, kForceShare{-10.0, 10.0}, kForceGain{0.1, 10.0},
    kReadingGain{0.1, 10.0}, kPeak{0.01, 100.0}, kModelLengthMm{-1e5, 1e5};

Eigen::VectorXd vector_of(const std::vector<double>& numbers) {
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

// Of as many joints as the arm of the check had; that the rig's has as many is void_reason()'s to say.
device::JointVector joints_of(const TomlTable& table, std::string_view key, NumberRange range) {
  const auto numbers = table.numbers(key, 0, range);
  if (numbers.size() < 3 || numbers.size() > device::kMostJoints) {
    table.complain(key, fmt::format("has {} numbers, one for each of 3 to {} joints is expected",
                                    numbers.size(), device::kMostJoints));
    return device::JointVector::filled(3, 0.0);
  }
  return vector_of(numbers);
}

// Of this name and a unit: angles, or what a Cartesian arm states.
device::JointVector readings_of(const TomlTable& table, const std::string& name, bool places) {
  if (places) return joints_of(table, name + "_mm", kModelLengthMm) / kMillimetresPerMetre;
  return joints_of(table, name + "_deg", kTurnDeg) / kDegreesPerRadian;
}

}  // namespace

std::optional<ForceCalibration> forces_of(const TomlTable& table) {
  if (!table.exists()) return std::nullopt;
  ForceCalibration forces;
  forces.identity = table.text("arm");
  if (forces.identity.empty())
    table.complain("arm", "is empty; the arm's name, as its driver tells it, is expected");
  forces.model = table.text("model");
  forces.model_numbers.lengths =
      vector_of(table.numbers("model_lengths_mm", 0, kModelLengthMm)) / kMillimetresPerMetre;
  forces.model_numbers.angles = vector_of(table.numbers("model_angles_deg", 0, kTurnDeg)) / kDegreesPerRadian;
  forces.nominal_numbers.lengths =
      vector_of(table.numbers("nominal_lengths_mm", 0, kModelLengthMm)) / kMillimetresPerMetre;
  forces.nominal_numbers.angles =
      vector_of(table.numbers("nominal_angles_deg", 0, kTurnDeg)) / kDegreesPerRadian;
  forces.states_place = table.has("rest_readings_mm");
  forces.rest_readings = readings_of(table, "rest_readings", forces.states_place);
  forces.joint_offsets = readings_of(table, "offsets", forces.states_place);
  forces.reading_gains = joints_of(table, "gains", kReadingGain);
  const auto map = table.rows("map", 3, 3, kForceShare);
  for (std::size_t i = 0; i < map.size(); ++i)
    for (std::size_t j = 0; j < 3; ++j)
      forces.map(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = map[i][j];
  if (table.has("map_covariance")) {
    const auto C = table.rows("map_covariance", 9, 9);
    forces.covariance.resize(9, 9);
    for (std::size_t i = 0; i < C.size(); ++i)
      for (std::size_t j = 0; j < 9; ++j)
        forces.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = C[i][j];
    if (C.size() == 9 && forces.covariance.diagonal().minCoeff() < 0.0)
      table.complain("map_covariance", "has a negative variance on its diagonal");
  } else {
    table.expect("map_covariance");
  }
  forces.joint_gains = vector_of(table.numbers("joint_gains", 0, kForceShare));
  if (table.has("joint_gains_std"))
    forces.joint_gains_std = vector_of(
        table.numbers("joint_gains_std", static_cast<std::size_t>(forces.joint_gains.size()), kNotNegative));
  else
    table.expect("joint_gains_std");
  table.expect("gain");
  if (table.has("gain")) forces.gain = table.number("gain", kForceGain);
  forces.gain_std = table.number_or("gain_std", 0.0, kNotNegative);
  forces.peak = table.number("peak_n", kPeak);
  if (!forces.gain && forces.peak > kUnweighedPeak)
    table.complain(
        "peak_n", fmt::format("is {:g}; without a gain, which a known weight tells, at most {:g} is expected",
                              forces.peak, kUnweighedPeak));
  forces.dead_man_button = static_cast<int>(table.integer_or("dead_man_button", 0, {0, 32}));
  forces.date = table.text_or("date", "");
  forces.method = table.text_or("method", "");
  forces.data_hash = table.text_or("data_hash", "");
  std::tm when{};
  if (!forces.date.empty() &&
      (forces.date.size() != 20 || ::strptime(forces.date.c_str(), "%Y-%m-%dT%H:%M:%SZ", &when) == nullptr))
    table.complain("date",
                   fmt::format("is '{}', a UTC time such as 2026-01-31T12:00:00Z is expected", forces.date));
  return forces;
}

std::string forces_text(const std::optional<ForceCalibration>& part) {
  if (!part) return "";
  const ForceCalibration& forces = *part;
  std::string text = "\n[forces]\n";
  const auto put = [&](std::string_view key, const std::string& value) {
    text += fmt::format("{} = {}\n", key, value);
  };
  text += "# Of this arm, with this model and zero: forces have been seen to go where they are commanded.\n";
  put("arm", toml_quoted(forces.identity));
  put("model", toml_quoted(forces.model));
  put("model_lengths_mm", number_list(forces.model_numbers.lengths, kMillimetresPerMetre));
  put("model_angles_deg", number_list(forces.model_numbers.angles, kDegreesPerRadian));
  put("nominal_lengths_mm", number_list(forces.nominal_numbers.lengths, kMillimetresPerMetre));
  put("nominal_angles_deg", number_list(forces.nominal_numbers.angles, kDegreesPerRadian));
  const auto put_readings = [&](const std::string& name, const device::JointVector& readings) {
    if (forces.states_place)
      put(name + "_mm", number_list(readings, kMillimetresPerMetre));
    else
      put(name + "_deg", number_list(readings, kDegreesPerRadian));
  };
  put_readings("rest_readings", forces.rest_readings);
  put_readings("offsets", forces.joint_offsets);
  put("gains", number_list(forces.reading_gains));
  text +=
      "# Felt over commanded force, ArmBase axes, of size 1; torque over commanded torque, joint by joint.\n";
  put("map", number_rows(forces.map));
  put("joint_gains", number_list(forces.joint_gains));
  if (forces.joint_gains_std.size() > 0) put("joint_gains_std", number_list(forces.joint_gains_std));
  if (forces.gain) {
    text += "# Felt over commanded size, by a known weight.\n";
    put("gain", toml_number(*forces.gain));
    put("gain_std", toml_number(forces.gain_std));
  }
  put("peak_n", toml_number(forces.peak));
  if (forces.dead_man_button > 0) put("dead_man_button", std::to_string(forces.dead_man_button));
  for (const auto& [key, value] : {std::pair{"date", &forces.date}, std::pair{"data_hash", &forces.data_hash},
                                   std::pair{"method", &forces.method}})
    if (!value->empty()) put(key, toml_quoted(*value));
  if (forces.covariance.size() > 0) {
    text += "# Of the map, row by row.\n";
    put("map_covariance", number_rows(forces.covariance));
  }
  return text;
}

}  // namespace palpate::rig
