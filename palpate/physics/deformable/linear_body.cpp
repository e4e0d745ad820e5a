#include "palpate/physics/deformable/linear_body.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace palpate::physics::deformable {
namespace {

constexpr int kUnitLoadsAtOnce = 32;
constexpr double kNoChange = 1e-9;  // of the largest entry

// Where the difference has an entry, in rising order.
std::vector<int> changed_equations(const SymmetricMatrix& bare, const SymmetricMatrix& with) {
  double largest = 0.0;
  for (const double value : bare.values) largest = std::max(largest, std::abs(value));
  std::vector<bool> changed(static_cast<std::size_t>(bare.size), false);
  for (int column = 0; column < bare.size; ++column)
    for (auto k = static_cast<std::size_t>(bare.starts[static_cast<std::size_t>(column)]);
         k < static_cast<std::size_t>(bare.starts[static_cast<std::size_t>(column) + 1]); ++k)
      if (std::abs(with.values[k] - bare.values[k]) > kNoChange * largest)
        changed[static_cast<std::size_t>(column)] = changed[static_cast<std::size_t>(bare.rows[k])] = true;
  std::vector<int> equations;
  for (int e = 0; e < bare.size; ++e)
    if (changed[static_cast<std::size_t>(e)]) equations.push_back(e);
  return equations;
}

// The difference among these equations, dense.
Eigen::MatrixXd difference(const SymmetricMatrix& bare, const SymmetricMatrix& with,
                           const std::vector<int>& equations) {
  std::vector<Eigen::Index> number(static_cast<std::size_t>(bare.size), -1);
  for (std::size_t k = 0; k < equations.size(); ++k)
    number[static_cast<std::size_t>(equations[k])] = static_cast<Eigen::Index>(k);
  const auto count = static_cast<Eigen::Index>(equations.size());
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(count, count);
  for (const int column : equations)
    for (auto k = static_cast<std::size_t>(bare.starts[static_cast<std::size_t>(column)]);
         k < static_cast<std::size_t>(bare.starts[static_cast<std::size_t>(column) + 1]); ++k) {
      const Eigen::Index i = number[static_cast<std::size_t>(bare.rows[k])];
      const Eigen::Index j = number[static_cast<std::size_t>(column)];
      if (i >= 0) D(i, j) = D(j, i) = with.values[k] - bare.values[k];
    }
  return D;
}

}  // namespace

SymmetricMatrix linear_stiffness(const TetMesh& mesh, const Material& material, const FreeMotion& motion) {
  auto matrix = stiffness_pattern(mesh, motion);
  Solid(mesh, material, Model::linear)
      .add_stiffness(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * mesh.nodes.size())), motion, matrix);
  return matrix;
}

Expected<SparseFactor> factorised(const SymmetricMatrix& matrix) {
  auto factor = SparseFactor::analyse(matrix);
  if (!factor) return factor;
  if (auto done = factor->factorise(matrix); !done) return tl::unexpected(done.error());
  return factor;
}

Expected<InclusionChange> InclusionChange::prepare(const SymmetricMatrix& bare, const SymmetricMatrix& with,
                                                   const SparseFactor& factor, const std::vector<int>& rows) {
  const auto equations = changed_equations(bare, with);
  const auto count = static_cast<Eigen::Index>(equations.size());
  InclusionChange result;
  result.columns_.resize(count, static_cast<Eigen::Index>(rows.size()));
  if (count == 0) return result;
  Eigen::MatrixXd compliance(count, count);
  for (Eigen::Index first = 0; first < count; first += kUnitLoadsAtOnce) {
    const Eigen::Index columns = std::min<Eigen::Index>(kUnitLoadsAtOnce, count - first);
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(bare.size, columns);
    for (Eigen::Index k = 0; k < columns; ++k) unit(equations[static_cast<std::size_t>(first + k)], k) = 1.0;
    if (auto solved = factor.solve(unit); !solved) return tl::unexpected(solved.error());
    result.columns_.middleRows(first, columns) = unit(rows, Eigen::all).transpose();
    compliance.middleCols(first, columns) = unit(equations, Eigen::all);
  }
  const Eigen::MatrixXd D = difference(bare, with, equations);
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(Eigen::MatrixXd::Identity(count, count) + D * compliance);
  result.change_ = lu.solve(D);
  if (!result.change_.allFinite()) return refused("inclusions: the changed body's stiffness is singular");
  return result;
}

Eigen::VectorXd InclusionChange::within(const Eigen::VectorXd& load) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(count());
  for (Eigen::Index row = 0; row < load.size(); ++row)
    if (load[row] != 0.0) sum += load[row] * columns_.col(row);
  return sum;
}

Eigen::MatrixXf InclusionChange::of_displacements(const Eigen::MatrixXd& within) const {
  const Eigen::MatrixXf forces = (change_ * within).cast<float>(), columns = columns_.cast<float>();
  return -(columns.transpose() * forces);
}

}  // namespace palpate::physics::deformable
