#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>

#include "palpate/calibration/absolute_orientation.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/point_file.h"
#include "palpate/device/repeats.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

struct PointsArguments {
  ResultOptions result;
  std::string from, to;
  std::string object, mesh, mesh_unit = "mm";
};

struct Pairs {
  std::vector<Vector3> from, to;
  std::vector<double> weights;
  std::vector<std::string> labels;
  bool by_label = false;
  std::size_t repeats = 0;  // rows left out
};

bool unique_labels(const device::PointFile& file) {
  return !file.labels.empty() &&
         std::set<std::string>(file.labels.begin(), file.labels.end()).size() == file.labels.size();
}

// By label where both lists have unique ones, else by order.
Expected<Pairs> pair_up(const device::PointFile& from, const device::PointFile& to) {
  Pairs pairs;
  pairs.by_label = unique_labels(from) && unique_labels(to);
  if (!pairs.by_label && from.points.size() != to.points.size())
    return wrong_use("{} has {}, {} has {}; lists of the same length, or with labels, are expected",
                     from.source, counted(from.points.size(), "point"), to.source, to.points.size());
  std::set<device::Reading> known;
  for (std::size_t i = 0; i < from.points.size(); ++i) {
    std::size_t j = i;
    if (pairs.by_label) {
      const auto at = std::find(to.labels.begin(), to.labels.end(), from.labels[i]);
      if (at == to.labels.end()) continue;
      j = static_cast<std::size_t>(at - to.labels.begin());
    }
    if (!known.insert(device::Reading().add(from.points[i]).add(to.points[j])).second) {
      ++pairs.repeats;
      continue;
    }
    pairs.from.push_back(from.points[i]);
    pairs.to.push_back(to.points[j]);
    pairs.labels.push_back(from.labels.empty() ? std::to_string(i + 1) : from.labels[i]);
    if (!to.weights.empty()) pairs.weights.push_back(to.weights[j]);
  }
  if (pairs.from.empty()) return wrong_use("{} and {} have no label in common", from.source, to.source);
  return pairs;
}

// What the fit says of single points and of the lists' sizes.
std::vector<std::string> warnings_of(const Pairs& pairs,
                                     const Estimate<calibration::RigidTransform>& estimate) {
  constexpr double kUnlike = 0.01, kSure = 5.0;  // of the size; standard deviations
  constexpr std::size_t kMostNamed = 5;
  std::vector<std::string> warnings;
  if (pairs.repeats > 0) warnings.push_back(device::repeats_warning(pairs.repeats));
  if (estimate.value.mirrored)
    warnings.push_back("a mirror image would fit better: one list may be left-handed or out of order");
  if (const auto stray = calibration::stray_points(estimate, pairs.weights); !stray.empty()) {
    std::vector<std::string> named;
    for (std::size_t k = 0; k < std::min(stray.size(), kMostNamed); ++k)
      named.push_back(fmt::format("'{}' by {:.3g} mm", excerpt(pairs.labels[stray[k]]),
                                  kMm * estimate.residuals[stray[k]].norm()));
    warnings.push_back(fmt::format("{} far off what suits the others: {}{}; measure again, or leave out",
                                   counted(stray.size(), "point") + (stray.size() == 1 ? " lies" : " lie"),
                                   fmt::join(named, ", "), stray.size() > kMostNamed ? ", ..." : ""));
  }
  const calibration::SizeRatio size = calibration::size_ratio(pairs.from, pairs.to, pairs.weights);
  if (std::abs(size.ratio - 1.0) > std::max(kUnlike, kSure * size.sd))
    warnings.push_back(
        fmt::format("the second list is {:.4f} +- {:.4f} times as large as the first, which no rotation "
                    "explains: do both measure in the same unit, and truly?",
                    size.ratio, size.sd));
  return warnings;
}

rig::RealObject* find_object(rig::Rig& rig, const std::string& name) {
  const auto at = std::find_if(rig.objects.begin(), rig.objects.end(),
                               [&](const auto& object) { return object.name == name; });
  return at == rig.objects.end() ? nullptr : &*at;
}

// The real body whose pose the result is, as the rig has it or --mesh makes it; without a name where none is meant.
// What is wrong with it is told before anything is computed.
Expected<rig::RealObject> body_of(const PointsArguments& options) {
  const std::string& written = options.result.rig.empty() ? options.result.out : options.result.rig;
  if (options.object.empty()) {
    if (!written.empty())
      return wrong_use(
          "--rig and --out: name the real body that these points belong to with --object; what has no place "
          "in a rig "
          "is written by --json");
    if (!options.mesh.empty()) return wrong_use("--mesh: goes with --object, whose shape it is");
    return rig::RealObject{};
  }
  if (written.empty())
    return wrong_use("--object {}: needs --rig, the rig file that the body is in", options.object);
  auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  rig::RealObject body;
  if (const auto* known = find_object(*rig, options.object)) body = *known;
  body.name = options.object;
  if (!options.mesh.empty()) {
    body.mesh = options.mesh;
    body.metres_per_unit = options.mesh_unit == "m" ? 1.0 : 1.0 / kMm;
    if (!is_there(std::filesystem::path(written).parent_path() / body.mesh))
      return wrong_use("--mesh {}: no such file, as seen from the folder of {}", options.mesh, written);
  }
  if (!body.mesh.empty()) return body;
  return wrong_use(
      "--object {}: {} has no [[object]] of that name; --mesh FILE, beside the rig file, makes one",
      excerpt(options.object), written);
}

void store_body(rig::Rig& rig, const rig::RealObject& body) {
  if (auto* there = find_object(rig, body.name))
    *there = body;
  else
    rig.objects.push_back(body);
}

Expected<void> run_points(const PointsArguments& options) {
  auto body = body_of(options);
  if (!body) return tl::unexpected(body.error());
  const auto from = device::read_points(options.from);
  if (!from) return tl::unexpected(from.error());
  const auto to = device::read_points(options.to);
  if (!to) return tl::unexpected(to.error());
  const auto pairs = pair_up(*from, *to);
  if (!pairs) return tl::unexpected(pairs.error());
  const auto estimate = calibration::absolute_orientation(pairs->from, pairs->to, pairs->weights);
  std::string stray;
  if (const auto odd = calibration::misplaced_point(pairs->from, pairs->to, pairs->weights))
    stray = fmt::format(
        "without point '{}' the others fit more than five times better: measure it again, or look "
        "whether it is paired rightly",
        excerpt(pairs->labels[*odd]));
  if (!estimate)
    return tl::unexpected(Error{
        estimate.error().kind, fmt::format("{}, {}: {}{}", from->source, to->source, estimate.error().message,
                                           stray.empty() ? "" : "; " + stray)});
  const calibration::RigidTransform& fit = estimate->value;
  const Quaternion rotation(fit.rotation);
  const auto std_all = standard_deviations(estimate->covariance);
  const double fre_mean = kMm * mean_norm(estimate->residuals);
  const double fre_rms = kMm * std::sqrt(3.0) * rms_per_component(estimate->residuals);
  Eigen::VectorXd scales(6);
  scales << Vector3::Constant(kDegreesPerRadian), Vector3::Constant(kMm);
  Result result;
  Json& json = result.json;
  json["rotation"] = json_rows(fit.rotation);
  json["rotation_qwxyz"] = json_quaternion(rotation);
  json["translation_mm"] = json_list(fit.translation, kMm);
  json["fre_mean_mm"] = fre_mean;
  json["fre_rms_mm"] = fre_rms;
  json["rms_mm"] = kMm * rms_per_component(estimate->residuals);
  json["points"] = pairs->from.size();
  json["paired_by"] = pairs->by_label ? "label" : "order";
  json["residuals_mm"] = Json::array();
  for (std::size_t i = 0; i < pairs->labels.size(); ++i)
    json["residuals_mm"].push_back(
        Json{{"label", pairs->labels[i]}, {"xyz", json_list(estimate->residuals[i], kMm)}});
  json["condition"] = estimate->condition;
  json["std"] = Json{{"rotation_deg", json_list(std_all.head<3>(), kDegreesPerRadian)},
                     {"translation_mm", json_list(std_all.tail<3>(), kMm)}};
  json["covariance"] = json_covariance({"rotation_x_deg", "rotation_y_deg", "rotation_z_deg",
                                        "translation_x_mm", "translation_y_mm", "translation_z_mm"},
                                       estimate->covariance, scales);
  json["warnings"] = warnings_of(*pairs, *estimate);
  if (!stray.empty()) json["warnings"].push_back(stray);
  json["data"] = Json{{"from", {{"file", from->source}, {"hash", from->hash}}},
                      {"to", {{"file", to->source}, {"hash", to->hash}}}};
  result.summary = {
      fmt::format("translation  {} mm  +- {}", shown(fit.translation, kMm), shown(std_all.tail<3>(), kMm)),
      fmt::format("rotation     {:.4f} deg about {}", degrees_from_radians(so3_log(rotation).norm()),
                  shown(so3_log(rotation).normalized())),
      fmt::format("residual     {:.4f} mm mean, {:.4f} mm rms, {} points", fre_mean, fre_rms,
                  pairs->from.size())};
  for (const auto& warning : json["warnings"])
    result.summary.push_back("warning: " + warning.get<std::string>());
  body->rotation = rotation;
  body->position = fit.translation;
  if (!body->name.empty()) result.store = [&](rig::Rig& rig) { store_body(rig, *body); };
  return write_result(options.result, result);
}

}  // namespace

void add_calibrate_points(CLI::App& calibrate) {
  auto options = std::make_shared<PointsArguments>();
  auto* command =
      calibrate.add_subcommand("points", "The rotation and translation between two lists of points");
  command->add_option("--from", options->from, "Points A, CSV")->type_name("A.csv");
  command->add_option("--to", options->to, "Points B, CSV; B = R A + t")->type_name("B.csv");
  command
      ->add_option(
          "--object", options->object,
          "The real body that A are points of, in its mesh's frame, and B the same touched in World: its "
          "[[object]] in --rig gets this pose")
      ->type_name("NAME");
  command
      ->add_option(
          "--mesh", options->mesh,
          "Its shape, as seen from the rig file's folder: STL, OBJ or PLY; where the rig has it not yet")
      ->type_name("FILE");
  command->add_option("--mesh-unit", options->mesh_unit, "Of the numbers in that file")
      ->check(one_of({"mm", "m"}))
      ->capture_default_str();
  add_result_options(*command, options->result);
  const auto tables = std::make_shared<TableSource>();
  tables->add("--from", options->from, "points_a");
  tables->add("--to", options->to, "points_b");
  tables->add_options(*command, false);
  on(command, tables, [options] { return run_points(*options); });
}

}  // namespace palpate::tools::commands
