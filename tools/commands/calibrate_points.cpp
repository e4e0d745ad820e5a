#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>

#include "palpate/calibration/findings/points.h"
#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/point_file.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/files_of_others.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

namespace findings = calibration::findings;

struct PointsArguments {
  ResultOptions result;
  std::string from, to;
  std::string object, mesh, mesh_unit = "mm";
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
  if (pairs.from.empty())
    return wrong_use(
        "{} and {} have no label in common; points go together by label where both lists have labels: the "
        "same labels "
        "are expected, or a list without them, whose points then go by their order",
        from.source, to.source);
  return pairs;
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
  const auto from = read_points(options.from);
  if (!from) return tl::unexpected(from.error());
  const auto to = read_points(options.to);
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
  if (const std::size_t most = std::max(from->points.size(), to->points.size()),
      paired = json["points"].get<std::size_t>();
      paired < most)
    json["warnings"].push_back(
        fmt::format("{} of {} points have no partner of the same label in the other list, and are left out",
                    most - paired, most));
  if (from->hash == to->hash)
    json["warnings"].push_back(fmt::format("{} holds the same as {}: the same points in two frames are meant",
                                           options.to, options.from));
  result.summary = {
      fmt::format("translation  {} mm  +- {}", shown(fit.translation, kMm), shown(std_all.tail<3>(), kMm)),
      fmt::format("rotation     {:.4f} deg about {}", degrees_from_radians(so3_log(rotation).norm()),
                  shown(so3_log(rotation).normalized())),
      fmt::format("residual     {:.4f} mm mean, {:.4f} mm rms, {} points", json["fre_mean_mm"].get<double>(),
                  json["fre_rms_mm"].get<double>(), json["points"].get<std::size_t>())};
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
  command
      ->add_option("--from", options->from,
                   "Points A, CSV; where both lists have labels, they go together by them, else by order")
      ->type_name("A.csv");
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
