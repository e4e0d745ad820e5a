// palpate study indent: a block of soft matter pressed by a sphere, by finite elements or by the haptic loop's law.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/core/progress.h"
#include "palpate/core/units.h"
#include "palpate/physics/deformable/quick_indentation.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {
namespace {

namespace deformable = physics::deformable;

struct IndentCommand {
  double young_kpa = 6.0, poisson = 0.45, radius_mm = 8.0, inclusion_ratio = 10.0, friction = 0.0;
  std::vector<double> size_mm{106.347, 106.347, 50.0}, depths_mm, inclusion_mm;
  std::string model = "neo-hookean", method = "full", json;
};

deformable::Indentation indentation_of(const IndentCommand& options) {
  deformable::Indentation it;
  it.material.matrix = {1000.0 * options.young_kpa, options.poisson};
  const auto vector_of = [](const std::vector<double>& mm) {
    return Vector3(metres_from_mm(mm[0]), metres_from_mm(mm[1]), metres_from_mm(mm[2]));
  };
  it.size = vector_of(options.size_mm);
  it.radius = metres_from_mm(options.radius_mm);
  it.friction = options.friction;
  it.model = options.model == "linear" ? deformable::Model::linear : deformable::Model::neo_hookean;
  for (const double depth : options.depths_mm) it.depths.push_back(metres_from_mm(depth));
  if (!options.inclusion_mm.empty()) {
    // z downwards on the command line, upwards in the block's frame.
    const Vector3 centre = vector_of(options.inclusion_mm).cwiseProduct(Vector3(1.0, 1.0, -1.0));
    const double radius = metres_from_mm(options.inclusion_mm[3]);
    it.material.inclusions.push_back({centre, Vector3::Constant(radius), options.inclusion_ratio});
  }
  return it;
}

Expected<void> run_indent(const IndentCommand& options) {
  Progress progress({{"indent", 1.0}});
  progress.begin(0);
  const auto indentation = indentation_of(options);
  const auto points =
      options.method == "tick"
          ? deformable::quick_indentation(indentation)
          : deformable::solve_indentation(indentation, [&progress](double share) { progress.update(share); });
  progress.finish();
  if (!points) return tl::unexpected(points.error());
  Json rows = Json::array();
  for (const auto& point : *points) {
    const double depth = mm_from_metres(point.depth), contact = mm_from_metres(point.contact_radius);
    rows.push_back({{"depth_mm", depth}, {"force_n", point.force}, {"contact_radius_mm", contact}});
    print_line(fmt::format("{:8.3f} mm {:10.5f} N  contact {:.2f} mm", depth, point.force, contact), stderr);
  }
  if (!options.json.empty())
    return write_json(options.json,
                      Json{{"model", options.model}, {"method", options.method}, {"points", rows}});
  return {};
}

}  // namespace

void add_study_indent(CLI::App& study) {
  auto* indent = study.add_subcommand("indent", "A soft block pressed by a sphere in the middle of its top");
  auto options = std::make_shared<IndentCommand>();
  indent->add_option("--young-kpa", options->young_kpa, "Young's modulus")->capture_default_str();
  indent->add_option("--poisson", options->poisson, "Poisson's ratio, 0 to 0.495")->capture_default_str();
  indent->add_option("--radius-mm", options->radius_mm, "The sphere's radius")->capture_default_str();
  indent->add_option("--size-mm", options->size_mm, "The block's X,Y,Z; Z is its height")
      ->delimiter(',')
      ->expected(3)
      ->capture_default_str();
  indent
      ->add_option("--depths-mm", options->depths_mm, "How deep the top is pressed, from its first touch on")
      ->delimiter(',')
      ->required();
  indent
      ->add_option("--inclusion-mm", options->inclusion_mm,
                   "A ball X,Y,Z,R in the block: its centre from the middle of the top, Z downwards")
      ->delimiter(',')
      ->expected(4);
  indent->add_option("--inclusion-ratio", options->inclusion_ratio, "Its stiffness over the block's")
      ->capture_default_str();
  indent->add_option("--model", options->model, "Small strains (linear) or neo-Hookean")
      ->check(one_of({"linear", "neo-hookean"}))
      ->capture_default_str();
  indent->add_option("--method", options->method, "Finite elements (full) or the haptic loop's law (tick)")
      ->check(one_of({"full", "tick"}))
      ->capture_default_str();
  indent->add_option("--friction", options->friction, "Coulomb's coefficient between tip and block")
      ->capture_default_str();
  indent->add_option("--json", options->json, "Depths, forces and contact radii, - for standard output");
  on(indent, [options] { return run_indent(*options); });
}

}  // namespace palpate::tools::commands
