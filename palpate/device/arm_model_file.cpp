#include "palpate/device/arm_model_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/units.h"

namespace palpate::device {
namespace {

constexpr NumberRange kLengthMm{-1e5, 1e5}, kAngleDeg{-360.0, 360.0};

JointRange range_of(const TomlTable& joint) {
  JointRange range;
  if (!joint.has("range_deg")) return joint.expect("range_deg"), range;
  const auto ends = joint.numbers<2>("range_deg", kAngleDeg);
  range.low = radians_from_degrees(ends[0]);
  range.high = radians_from_degrees(ends[1]);
  if (!(range.low < range.high))
    joint.complain("range_deg",
                   fmt::format("is {:g} to {:g}, the lower end first is expected", ends[0], ends[1]));
  return range;
}

Quaternion tool_turn_of(const TomlTable& table) {
  const auto v = table.numbers_or<4>("tool_qwxyz", {1.0, 0.0, 0.0, 0.0}, {-1.0, 1.0});
  const Quaternion q(v[0], v[1], v[2], v[3]);
  if (std::abs(q.norm() - 1.0) <= 1e-6) return q;
  table.complain("tool_qwxyz",
                 fmt::format("is no rotation: w, x, y, z have length {:g}, 1 is expected", q.norm()));
  return Quaternion::Identity();
}

std::string list(std::initializer_list<double> numbers) {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "" : ", ") + toml_number(number);
  return "[" + text + "]";
}

}  // namespace

void read_dh_chain(const TomlTable& table, ArmModel& model) {
  model.kind = ArmModel::Kind::dh;
  for (const auto& joint : table.tables("joint"))
    model.joints.push_back({metres_from_mm(joint.number("a_mm", kLengthMm)),
                            radians_from_degrees(joint.number("alpha_deg", kAngleDeg)),
                            metres_from_mm(joint.number("d_mm", kLengthMm)),
                            radians_from_degrees(joint.number_or("theta_offset_deg", 0.0, kAngleDeg)),
                            range_of(joint)});
  if (model.joints.empty()) table.complain("joint", "is missing, one [[joint]] table per joint is expected");
  model.tool_known = table.has("tool_mm");
  const auto tool = table.numbers_or<3>("tool_mm", {0.0, 0.0, 0.0}, kLengthMm);
  for (int i = 0; i < 3; ++i) model.tool[i] = metres_from_mm(tool[static_cast<std::size_t>(i)]);
  model.tool_turn = tool_turn_of(table);
}

void read_cartesian(const TomlTable& table, ArmModel& model) {
  constexpr NumberRange kTermMm{-1000.0, 1000.0};
  model.kind = ArmModel::Kind::cartesian;
  Vector3 low = Vector3::Zero(), high = Vector3::Zero();
  const auto rows = table.rows("range_mm", 2, 3, kLengthMm);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    low[axis] = metres_from_mm(rows[i][0]), high[axis] = metres_from_mm(rows[i][1]);
    model.places[i] = {low[axis], high[axis]};
    if (!(low[axis] < high[axis]))
      table.complain("range_mm", fmt::format("is {:g} to {:g} along {}, the lower end first is expected",
                                             rows[i][0], rows[i][1], "xyz"[i]));
  }
  model.correction.centre = 0.5 * (low + high);
  model.correction.reach = std::max(1e-3, 0.5 * (high - low).maxCoeff());
  model.correction.terms.setZero();
  if (!table.has("correction_mm")) return table.expect("correction_mm");
  const auto terms = table.numbers<PlaceCorrection::kTerms>("correction_mm", kTermMm);
  for (int k = 0; k < PlaceCorrection::kTerms; ++k)
    model.correction.terms[k] = metres_from_mm(terms[static_cast<std::size_t>(k)]);
}

std::string cartesian_text(const ArmModel& model) {
  std::string ranges, terms;
  for (const auto& [low, high] : model.places)
    ranges += (ranges.empty() ? "" : ", ") + list({mm_from_metres(low), mm_from_metres(high)});
  std::string text = fmt::format("type = \"cartesian\"\nrange_mm = [{}]\n", ranges);
  if (model.correction.terms.isZero(0.0)) return text;
  for (const double term : model.correction.terms)
    terms += (terms.empty() ? "" : ", ") + toml_number(mm_from_metres(term));
  return text + fmt::format("correction_mm = [{}]\n", terms);
}

std::string tool_text(const ArmModel& model) {
  constexpr double kMm = kMillimetresPerMetre;
  const Vector3& p = model.tool;
  const Quaternion& q = model.tool_turn;
  return fmt::format("tool_mm = {}\ntool_qwxyz = {}\n", list({kMm * p.x(), kMm * p.y(), kMm * p.z()}),
                     list({q.w(), q.x(), q.y(), q.z()}));
}

std::string dh_joints_text(const ArmModel& model, const std::string& table) {
  std::string text;
  for (const auto& joint : model.joints) {
    text += fmt::format("\n[[{}]]\na_mm = {}\nalpha_deg = {}\nd_mm = {}\ntheta_offset_deg = {}\n", table,
                        toml_number(mm_from_metres(joint.a)), toml_number(degrees_from_radians(joint.alpha)),
                        toml_number(mm_from_metres(joint.d)),
                        toml_number(degrees_from_radians(joint.theta_offset)));
    if (joint.range.known())
      text +=
          fmt::format("range_deg = {}\n",
                      list({degrees_from_radians(joint.range.low), degrees_from_radians(joint.range.high)}));
  }
  return text;
}

}  // namespace palpate::device
