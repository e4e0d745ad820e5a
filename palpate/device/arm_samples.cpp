#include "palpate/device/arm_samples.h"

#include "palpate/core/file.h"
#include "palpate/core/units.h"
#include "palpate/device/pose_file.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::device {
namespace {

struct AngleColumns {
  std::vector<std::size_t> at;
  double radians_per_unit = 1.0;
};

// name_1_deg, name_2_deg ... (or _rad), as far as the numbers go on; with `bare`, name_1 ... in degrees.
AngleColumns find_angles(const CsvTable& table, const std::string& name, bool bare) {
  AngleColumns columns;
  for (const auto& [suffix, scale] : {std::pair{"_deg", 1.0 / kDegreesPerRadian}, std::pair{"_rad", 1.0},
                                      std::pair{"", 1.0 / kDegreesPerRadian}}) {
    if (*suffix == '\0' && !bare) break;
    columns = {{}, scale};
    while (const auto at = table.find(fmt::format("{}_{}{}", name, columns.at.size() + 1, suffix)))
      columns.at.push_back(*at);
    if (!columns.at.empty()) break;
  }
  return columns;
}

std::optional<std::array<std::size_t, 3>> find_triple(const CsvTable& table, const std::string& suffix) {
  const auto x = table.find("x" + suffix), y = table.find("y" + suffix), z = table.find("z" + suffix);
  if (x && y && z) return std::array<std::size_t, 3>{*x, *y, *z};
  return std::nullopt;
}

Vector3 triple(const std::vector<double>& row, const std::array<std::size_t, 3>& at, double scale) {
  return scale * Vector3(row[at[0]], row[at[1]], row[at[2]]);
}

}  // namespace

Expected<ArmSampleFile> read_arm_samples(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  return parse_arm_samples(*content, path.string());
}

Expected<ArmSampleFile> parse_arm_samples(std::string_view content, std::string source) {
  const auto parsed = parse_csv(content, std::move(source));
  if (!parsed) return tl::unexpected(parsed.error());
  const CsvTable& table = *parsed;
  ArmSampleFile file{table.source, content_hash(content), {}};

  const auto target = find_triple(table, "_t"), difference = find_triple(table, "_dif");
  const bool target_form = target && difference;
  const auto joints = find_angles(table, "joint", target_form);
  if (joints.at.empty()) return tl::unexpected(table.require("joint_1_deg").error());
  const auto gimbal = find_angles(table, "gimbal", false);
  if (!gimbal.at.empty() && gimbal.at.size() != 3)
    return wrong_use("{}: has {} gimbal columns, gimbal_1 to gimbal_3 are expected", table.source,
                     gimbal.at.size());
  const auto time = table.find("time_s");
  const auto systematic = table.find("systematic_mm");
  const auto marker = find_pose_columns(table, "marker_");
  const auto tip_mm = find_triple(table, "_mm"), tip_m = find_triple(table, "_m");
  if (!marker && !tip_mm && !tip_m && !target_form)
    return wrong_use(
        "{}: has joint readings but neither x_mm,y_mm,z_mm (measured tip) nor marker_x_mm,...,marker_qz "
        "(marker pose)",
        table.source);
  std::vector<std::size_t> covariance;
  double covariance_scale = 1.0;
  for (const auto& [unit, scale] : {std::pair{"_mm2", 1e-6}, std::pair{"_m2", 1.0}}) {
    if (!covariance.empty() || !table.has(std::string("cov_xx") + unit)) continue;
    covariance_scale = scale;
    for (const char* element : {"xx", "xy", "xz", "yy", "yz", "zz"}) {
      const auto at = table.require(fmt::format("cov_{}{}", element, unit));
      if (!at) return tl::unexpected(at.error());
      covariance.push_back(*at);
    }
  }

  const auto within = [&](const std::vector<std::size_t>& at, double limit) {
    return table.require_within(at, limit);
  };
  Expected<void> fine = within(joints.at, kLargestAngle / joints.radians_per_unit);
  if (fine) fine = within(gimbal.at, kLargestAngle / gimbal.radians_per_unit);
  if (fine && time) fine = within({*time}, kLatestTime);
  for (const auto& places : {target, difference, tip_mm})
    if (fine && places)
      fine = within({places->begin(), places->end()}, kMillimetresPerMetre * kFarthestPlace);
  if (fine && tip_m) fine = within({tip_m->begin(), tip_m->end()}, kFarthestPlace);
  if (fine) fine = within(covariance, kFarthestPlace * kFarthestPlace / covariance_scale);
  if (!fine) return tl::unexpected(fine.error());

  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto& row = table.rows[i];
    ArmObservation sample;
    sample.joints.resize(static_cast<Eigen::Index>(joints.at.size()));
    for (std::size_t j = 0; j < joints.at.size(); ++j)
      sample.joints[static_cast<Eigen::Index>(j)] = joints.radians_per_unit * row[joints.at[j]];
    if (!gimbal.at.empty())
      sample.gimbal = triple(row, {gimbal.at[0], gimbal.at[1], gimbal.at[2]}, gimbal.radians_per_unit);
    if (time) sample.time_s = row[*time];
    if (marker) {
      const auto pose = pose_from_row(table, i, *marker);
      if (!pose) return tl::unexpected(pose.error());
      sample.marker = pose->as<World, TipMarker>();
    }
    if (target_form) {
      sample.target = Point<World>{triple(row, *target, 1e-3)};
      sample.tip = Point<World>{sample.target->m + triple(row, *difference, 1e-3)};
    } else if (tip_mm || tip_m) {
      sample.tip = Point<World>{tip_mm ? triple(row, *tip_mm, 1e-3) : triple(row, *tip_m, 1.0)};
    }
    if (!covariance.empty()) {
      const auto c = [&](std::size_t k) { return covariance_scale * row[covariance[k]]; };
      Matrix3 C;
      Eigen::MatrixXd lower;
      C << c(0), c(1), c(2), c(1), c(3), c(4), c(2), c(4), c(5);
      if (!lower_cholesky(C, lower))
        return wrong_use("{}:{}: the covariance is not positive definite; repair or remove the cov_ columns",
                         table.source, table.line[i]);
      sample.covariance = C;
    }
    if (systematic) {
      if (row[*systematic] < 0.0)
        return wrong_use("{}:{}: systematic_mm is {}, a length of 0 or more is expected", table.source,
                         table.line[i], row[*systematic]);
      sample.systematic = 1e-3 * row[*systematic];
    }
    file.observations.push_back(std::move(sample));
  }
  if (file.observations.empty())
    return wrong_use("{}: holds a header but no samples; at least one row is expected", table.source);
  return file;
}

}  // namespace palpate::device
