#include "palpate/device/arm_samples.h"

#include "palpate/core/file.h"
#include "palpate/core/text.h"
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

using Triple = std::array<std::size_t, 3>;  // columns of x, y, z

std::optional<Triple> find_triple(const CsvTable& table, const std::string& suffix) {
  const auto x = table.find("x" + suffix), y = table.find("y" + suffix), z = table.find("z" + suffix);
  if (x && y && z) return Triple{*x, *y, *z};
  return std::nullopt;
}

Vector3 triple(const std::vector<double>& row, const Triple& at, double scale) {
  return scale * Vector3(row[at[0]], row[at[1]], row[at[2]]);
}

// arm_x_mm, arm_y_mm, arm_z_mm (or _m): metres per unit in place of radians.
AngleColumns find_stated_place(const CsvTable& table) {
  for (const auto& [suffix, scale] : {std::pair{"_mm", 1e-3}, std::pair{"_m", 1.0}}) {
    const auto x = table.find(std::string("arm_x") + suffix), y = table.find(std::string("arm_y") + suffix),
               z = table.find(std::string("arm_z") + suffix);
    if (x && y && z) return {{*x, *y, *z}, scale};
  }
  return {};
}

// Where in a table the parts of a sample stand; what has no place is not there.
struct SampleColumns {
  AngleColumns joints, gimbal;
  bool places = false;                       // the "joints" are a place, and their unit a length
  std::optional<Triple> target, difference;  // both or neither are used
  std::optional<Triple> tip_mm, tip_m;
  std::optional<std::size_t> time, systematic;
  std::optional<PoseColumns> marker;
  std::vector<std::size_t> covariance;  // xx xy xz yy yz zz
  double covariance_scale = 1.0;        // m^2 per unit

  bool target_form() const { return target && difference; }
};

Expected<void> find_covariance(const CsvTable& table, SampleColumns& columns) {
  for (const auto& [unit, scale] : {std::pair{"_mm2", 1e-6}, std::pair{"_m2", 1.0}}) {
    if (!columns.covariance.empty() || !table.has(std::string("cov_xx") + unit)) continue;
    columns.covariance_scale = scale;
    for (const char* element : {"xx", "xy", "xz", "yy", "yz", "zz"}) {
      const auto at = table.require(fmt::format("cov_{}{}", element, unit));
      if (!at) return tl::unexpected(at.error());
      columns.covariance.push_back(*at);
    }
  }
  return {};
}

Expected<SampleColumns> find_columns(const CsvTable& table) {
  SampleColumns columns;
  columns.target = find_triple(table, "_t");
  columns.difference = find_triple(table, "_dif");
  columns.joints = find_angles(table, "joint", columns.target_form());
  if (columns.joints.at.empty()) {
    columns.joints = find_stated_place(table);
    columns.places = !columns.joints.at.empty();
  }
  if (columns.joints.at.empty()) {
    const Error missing = table.require("joint_1_deg").error();
    return tl::unexpected(
        Error{missing.kind, missing.message + " (an arm's samples are its joints, joint_1_deg ..., or its "
                                              "place, arm_x_mm ..., beside what the tracker saw)"});
  }
  columns.gimbal = find_angles(table, "gimbal", false);
  if (!columns.gimbal.at.empty() && columns.gimbal.at.size() != 3)
    return wrong_use("{}: has {} gimbal columns, gimbal_1 to gimbal_3 are expected", table.source,
                     columns.gimbal.at.size());
  columns.time = table.find("time_s");
  columns.systematic = table.find("systematic_mm");
  columns.marker = find_pose_columns(table, "marker_");
  columns.tip_mm = find_triple(table, "_mm");
  columns.tip_m = find_triple(table, "_m");
  if (!columns.marker && !columns.tip_mm && !columns.tip_m && !columns.target_form())
    return wrong_use(
        "{}: has joint readings but neither x_mm,y_mm,z_mm (measured tip) nor marker_x_mm,...,marker_qz "
        "(marker pose)",
        table.source);
  if (auto fine = find_covariance(table, columns); !fine) return tl::unexpected(fine.error());
  return columns;
}

// What the tracker saw: where none of it is a number, the marker was hidden.
std::vector<std::size_t> seen_columns(const SampleColumns& columns) {
  std::vector<std::size_t> at;
  for (const auto& places : {columns.difference, columns.tip_mm, columns.tip_m})
    if (places) at.insert(at.end(), places->begin(), places->end());
  if (const auto& m = columns.marker) at.insert(at.end(), {m->x, m->y, m->z, m->qw, m->qx, m->qy, m->qz});
  return at;
}

Expected<void> check_ranges(const CsvTable& table, const SampleColumns& columns) {
  const auto within = [&](const std::vector<std::size_t>& at, double limit) {
    return table.require_within(at, limit);
  };
  Expected<void> fine = within(
      columns.joints.at, (columns.places ? kFarthestPlace : kLargestAngle) / columns.joints.radians_per_unit);
  if (fine) fine = within(columns.gimbal.at, kLargestAngle / columns.gimbal.radians_per_unit);
  if (fine && columns.time) fine = within({*columns.time}, kLatestTime);
  for (const auto& places : {columns.target, columns.difference, columns.tip_mm})
    if (fine && places)
      fine = within({places->begin(), places->end()}, kMillimetresPerMetre * kFarthestPlace);
  if (fine && columns.tip_m) fine = within({columns.tip_m->begin(), columns.tip_m->end()}, kFarthestPlace);
  if (fine) fine = within(columns.covariance, kFarthestPlace * kFarthestPlace / columns.covariance_scale);
  if (fine && columns.systematic) fine = table.require_numbers({*columns.systematic});
  if (fine && columns.marker) {
    const auto& m = *columns.marker;
    fine = table.require_numbers({m.x, m.y, m.z, m.qw, m.qx, m.qy, m.qz});
  }
  return fine;
}

Expected<Matrix3> covariance_from_row(const CsvTable& table, std::size_t i, const SampleColumns& columns) {
  const auto c = [&](std::size_t k) {
    return columns.covariance_scale * table.rows[i][columns.covariance[k]];
  };
  Matrix3 C;
  Eigen::MatrixXd lower;
  C << c(0), c(1), c(2), c(1), c(3), c(4), c(2), c(4), c(5);
  if (!lower_cholesky(C, lower))
    return wrong_use("{}:{}: the covariance is not positive definite; repair or remove the cov_ columns",
                     table.source, table.line[i]);
  return C;
}

Expected<ArmObservation> sample_from_row(const CsvTable& table, std::size_t i, const SampleColumns& columns) {
  const auto& row = table.rows[i];
  const auto &joints = columns.joints, &gimbal = columns.gimbal;
  ArmObservation sample;
  sample.line = table.line[i];
  sample.joints.resize(static_cast<Eigen::Index>(joints.at.size()));
  for (std::size_t j = 0; j < joints.at.size(); ++j)
    sample.joints[static_cast<Eigen::Index>(j)] = joints.radians_per_unit * row[joints.at[j]];
  if (!gimbal.at.empty())
    sample.gimbal = triple(row, {gimbal.at[0], gimbal.at[1], gimbal.at[2]}, gimbal.radians_per_unit);
  if (columns.time) sample.time_s = row[*columns.time];
  if (columns.marker) {
    const auto pose = pose_from_row(table, i, *columns.marker);
    if (!pose) return tl::unexpected(pose.error());
    sample.marker = pose->as<World, TipMarker>();
  }
  if (columns.target_form()) {
    sample.target = Point<World>{triple(row, *columns.target, 1e-3)};
    sample.tip = Point<World>{sample.target->m + triple(row, *columns.difference, 1e-3)};
  } else if (columns.tip_mm || columns.tip_m) {
    sample.tip =
        Point<World>{columns.tip_mm ? triple(row, *columns.tip_mm, 1e-3) : triple(row, *columns.tip_m, 1.0)};
  }
  if (!columns.covariance.empty()) {
    const auto covariance = covariance_from_row(table, i, columns);
    if (!covariance) return tl::unexpected(covariance.error());
    sample.covariance = *covariance;
  }
  if (columns.systematic) {
    const double systematic = row[*columns.systematic];
    if (systematic < 0.0)
      return wrong_use("{}:{}: systematic_mm is {}, a length of 0 or more is expected", table.source,
                       table.line[i], systematic);
    sample.systematic = 1e-3 * systematic;
  }
  return sample;
}

}  // namespace

Expected<ArmSampleFile> read_arm_samples(const std::filesystem::path& path) {
  const auto content = read_file(path);
  if (!content) return tl::unexpected(content.error());
  return parse_arm_samples(*content, path.string());
}

Expected<ArmSampleFile> parse_arm_samples(std::string_view content, std::string source) {
  auto parsed = parse_csv(content, std::move(source));
  if (!parsed) return tl::unexpected(parsed.error());
  const auto columns = find_columns(*parsed);
  if (!columns) return tl::unexpected(columns.error());
  ArmSampleFile file{parsed->source, content_hash(content), columns->places, {}, 0};
  file.left_out = parsed->leave_out_rows_without(seen_columns(*columns));
  if (auto fine = check_ranges(*parsed, *columns); !fine) return tl::unexpected(fine.error());
  for (std::size_t i = 0; i < parsed->rows.size(); ++i) {
    auto sample = sample_from_row(*parsed, i, *columns);
    if (!sample) return tl::unexpected(sample.error());
    file.observations.push_back(std::move(*sample));
  }
  if (file.observations.empty() && file.left_out > 0)
    return wrong_use("{}: the marker is seen in none of {}; rows in which it is seen are needed",
                     parsed->source, counted(file.left_out, "row"));
  if (file.observations.empty())
    return wrong_use("{}: holds a header but no samples; at least one row is expected", parsed->source);
  return file;
}

}  // namespace palpate::device
