#include "palpate/physics/organ/site_answers.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <future>

namespace palpate::physics::organ {
namespace {

constexpr int kSitesAtOnce = 32;
constexpr double kLeastLoad = 0.3;  // of a newton, that the mesh's surface catches at least

// One newton along the normal, all components; nothing where the disc lies mostly beside the mesh.
Eigen::VectorXd newton_at(const OrganMesh& body, const deformable::SurfaceSite& site, double radius) {
  Eigen::VectorXd load = deformable::hertz_load(body.mesh, site, radius);
  double caught = 0.0;
  for (const int node : body.surface_nodes) caught -= load.segment<3>(3 * node).dot(site.normal);
  if (caught < kLeastLoad)
    load.setZero();
  else
    load /= caught;
  return load;
}

// Equations of the surface's free components, and the rows of DentTable that they are.
struct SurfaceRows {
  std::vector<int> equations, components, rows;
  explicit SurfaceRows(const OrganMesh& body) {
    for (std::size_t n = 0; n < body.surface_nodes.size(); ++n)
      for (int axis = 0; axis < 3; ++axis) {
        const int component = 3 * body.surface_nodes[n] + axis;
        if (body.motion.equation(component) < 0) continue;
        equations.push_back(body.motion.equation(component));
        components.push_back(component);
        rows.push_back(static_cast<int>(3 * n) + axis);
      }
  }
};

}  // namespace

Expected<SiteTable> body_answers(const OrganMesh& body, const deformable::Elastic& matter,
                                 const deformable::SparseFactor& factor,
                                 const std::vector<deformable::SurfaceSite>& sites, const Share& progress) {
  const SurfaceRows surface(body);
  SiteTable answers;
  const auto count = static_cast<Eigen::Index>(sites.size());
  answers.moved = Eigen::MatrixXf::Zero(static_cast<Eigen::Index>(3 * body.surface_nodes.size()), count);
  for (Eigen::Index first = 0; first < count; first += kSitesAtOnce) {
    const Eigen::Index columns = std::min<Eigen::Index>(kSitesAtOnce, count - first);
    Eigen::MatrixXd loads(body.motion.count(), columns);
    for (Eigen::Index k = 0; k < columns; ++k)
      loads.col(k) =
          body.motion.free_part(newton_at(body, sites[static_cast<std::size_t>(first + k)], kBodyFootprint));
    Eigen::MatrixXd moved = loads;
    if (auto solved = factor.solve(moved); !solved) return tl::unexpected(solved.error());
    for (Eigen::Index k = 0; k < columns; ++k) {
      answers.own.push_back(loads.col(k).dot(moved.col(k)) -
                            deformable::half_space_answer(matter, kBodyFootprint));
      answers.moved.col(first + k)(surface.rows) = moved.col(k)(surface.equations).cast<float>();
    }
    if (progress && !progress(static_cast<double>(first + columns) / static_cast<double>(count)))
      return given_up();
  }
  return answers;
}

Expected<NoduleAnswers> nodule_answers(const OrganMesh& body, const deformable::Material& material,
                                       const deformable::SymmetricMatrix& bare,
                                       const deformable::SparseFactor& factor,
                                       const std::vector<deformable::SurfaceSite>& sites,
                                       const Share& progress) {
  const SurfaceRows surface(body);
  const auto with = deformable::linear_stiffness(body.mesh, material, body.motion);
  const auto change = deformable::InclusionChange::prepare(bare, with, factor, surface.equations);
  if (!change) return tl::unexpected(change.error());
  if (progress && !progress(0.5)) return given_up();
  const auto count = static_cast<Eigen::Index>(sites.size());
  NoduleAnswers answers;
  answers.change = Eigen::MatrixXd::Zero(count, kNoduleFootprints.size());
  answers.moved = Eigen::MatrixXf::Zero(static_cast<Eigen::Index>(3 * body.surface_nodes.size()), count);
  Eigen::MatrixXd wide_within(change->count(), count);
  std::atomic<bool> stopped{false};
  const auto each = [&](Eigen::Index first) {
    for (Eigen::Index i = first; i < count && !stopped; i += 2) {
      if (first == 0 && progress &&
          !progress(0.5 + 0.5 * static_cast<double>(i) / static_cast<double>(count)))
        stopped = true;
      const auto& site = sites[static_cast<std::size_t>(i)];
      const auto within = [&](double radius) {
        return change->within(newton_at(body, site, radius)(surface.components));
      };
      const Eigen::VectorXd wide = within(kBodyFootprint);
      wide_within.col(i) = wide;
      double last = change->of_answer(wide);
      for (auto k = static_cast<Eigen::Index>(kNoduleFootprints.size()) - 1; k >= 0; --k) {
        const Eigen::VectorXd narrow = within(kNoduleFootprints[static_cast<std::size_t>(k)]);
        // Where the mesh has no surface for so narrow a disc, what the next wider one says is kept.
        if (!narrow.isZero(0.0)) last = change->of_answer(narrow);
        answers.change(i, k) = last;
      }
    }
  };
  auto others = std::async(std::launch::async, each, 1);  // two sites at once
  each(0);
  others.get();
  if (stopped) return given_up();
  answers.moved(surface.rows, Eigen::all) = change->of_displacements(wide_within);
  return answers;
}

}  // namespace palpate::physics::organ
