#include <algorithm>
#include <memory>
#include <set>

#include "palpate/calibration/findings/points.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/point_file.h"
#include "tools/commands/command.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

namespace findings = calibration::findings;

struct PointsArguments {
  ResultOptions result;
  std::string from, to;
};

bool unique_labels(const device::PointFile& file) {
  return !file.labels.empty() &&
         std::set<std::string>(file.labels.begin(), file.labels.end()).size() == file.labels.size();
}

// By label where both lists have unique ones, else by order.
Expected<findings::PointPairs> pair_up(const device::PointFile& from, const device::PointFile& to) {
  findings::PointPairs pairs;
  pairs.by_label = unique_labels(from) && unique_labels(to);
  if (!pairs.by_label && from.points.size() != to.points.size())
    return wrong_use("{} has {}, {} has {}; lists of the same length, or with labels, are expected",
                     from.source, counted(from.points.size(), "point"), to.source, to.points.size());
  for (std::size_t i = 0; i < from.points.size(); ++i) {
    std::size_t j = i;
    if (pairs.by_label) {
      const auto at = std::find(to.labels.begin(), to.labels.end(), from.labels[i]);
      if (at == to.labels.end()) continue;
      j = static_cast<std::size_t>(at - to.labels.begin());
    }
    pairs.from.push_back(from.points[i]);
    pairs.to.push_back(to.points[j]);
    pairs.labels.push_back(from.labels.empty() ? std::to_string(i + 1) : from.labels[i]);
    if (!to.weights.empty()) pairs.weights.push_back(to.weights[j]);
  }
  if (pairs.from.empty()) return wrong_use("{} and {} have no label in common", from.source, to.source);
  return pairs;
}

Expected<void> run_points(const PointsArguments& options) {
  const auto from = device::read_points(options.from);
  if (!from) return tl::unexpected(from.error());
  const auto to = device::read_points(options.to);
  if (!to) return tl::unexpected(to.error());
  auto pairs = pair_up(*from, *to);
  if (!pairs) return tl::unexpected(pairs.error());
  const auto found = findings::find_rigid_motion(std::move(*pairs));
  if (!found)
    return tl::unexpected(Error{found.error().kind,
                                fmt::format("{}, {}: {}", from->source, to->source, found.error().message)});
  const Estimate<calibration::RigidTransform>& estimate = found->estimate;
  const calibration::RigidTransform& fit = estimate.value;
  const Quaternion rotation(fit.rotation);
  const auto std_all = standard_deviations(estimate.covariance);
  Result result{found->json, {}, {}};
  Json& json = result.json;
  json["data"] = Json{{"from", {{"file", from->source}, {"hash", from->hash}}},
                      {"to", {{"file", to->source}, {"hash", to->hash}}}};
  result.summary = {
      fmt::format("translation  {} mm  +- {}", shown(fit.translation, kMm), shown(std_all.tail<3>(), kMm)),
      fmt::format("rotation     {:.4f} deg about {}", degrees_from_radians(so3_log(rotation).norm()),
                  shown(so3_log(rotation).normalized())),
      fmt::format("residual     {:.4f} mm mean, {:.4f} mm rms, {} points", json["fre_mean_mm"].get<double>(),
                  json["fre_rms_mm"].get<double>(), json["points"].get<std::size_t>())};
  for (const auto& warning : json["warnings"])
    result.summary.push_back("warning: " + warning.get<std::string>());
  return write_result(options.result, result);
}

}  // namespace

void add_calibrate_points(CLI::App& calibrate) {
  auto options = std::make_shared<PointsArguments>();
  auto* command =
      calibrate.add_subcommand("points", "The rotation and translation between two lists of points");
  command->add_option("--from", options->from, "Points A, CSV")->type_name("A.csv");
  command->add_option("--to", options->to, "Points B, CSV; B = R A + t")->type_name("B.csv");
  add_result_options(*command, options->result);
  const auto tables = std::make_shared<TableSource>();
  tables->add("--from", options->from, "points_a");
  tables->add("--to", options->to, "points_b");
  tables->add_options(*command, false);
  on(command, tables, [options] { return run_points(*options); });
}

}  // namespace palpate::tools::commands
