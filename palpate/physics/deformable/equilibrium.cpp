#include "palpate/physics/deformable/equilibrium.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace palpate::physics::deformable {
namespace {

constexpr double kNear =
    0.3;  // forces left over, in parts of those of contact: the tip's curvature is counted
constexpr double kSlow = 0.35;  // a step that leaves more of the forces than this calls for a new factor
constexpr double kTouchTolerance = 1e-9;  // the same, in the small system
constexpr double kHeld = 0.02;            // of the contact's stiffness
constexpr int kHalvings = 20;
constexpr int kMostTouches = 100;

void stiffen_diagonal(double share, SymmetricMatrix& matrix) {
  for (int column = 0; column < matrix.size; ++column)
    matrix.values[static_cast<std::size_t>(matrix.starts[static_cast<std::size_t>(column)])] *= 1.0 + share;
}

void add_to_dense(const SymmetricMatrix& matrix, Eigen::MatrixXd& dense) {
  for (int column = 0; column < matrix.size; ++column)
    for (int k = matrix.starts[static_cast<std::size_t>(column)];
         k < matrix.starts[static_cast<std::size_t>(column) + 1]; ++k)
      dense(matrix.rows[static_cast<std::size_t>(k)], column) += matrix.values[static_cast<std::size_t>(k)];
}

FreeMotion touched_part(const TetMesh& mesh, const TipContact& contact, const FreeMotion& motion) {
  std::vector<bool> is_touched(mesh.nodes.size(), false);
  for (const int node : contact.nodes()) is_touched[static_cast<std::size_t>(node)] = true;
  FreeMotion touched(mesh);
  for (int node = 0; node < static_cast<int>(mesh.nodes.size()); ++node)
    for (int axis = 0; axis < 3; ++axis)
      if (!is_touched[static_cast<std::size_t>(node)] || motion.equation(3 * node + axis) < 0)
        touched.hold(node, axis);
  touched.number();
  return touched;
}

// Of the touched components, among all that are free.
std::vector<int> touched_equations(const TipContact& contact, const FreeMotion& touched,
                                   const FreeMotion& motion) {
  std::vector<int> equations(static_cast<std::size_t>(touched.count()));
  for (const int node : contact.nodes())
    for (int axis = 0; axis < 3; ++axis)
      if (const int number = touched.equation(3 * node + axis); number >= 0)
        equations[static_cast<std::size_t>(number)] = motion.equation(3 * node + axis);
  return equations;
}

}  // namespace

Equilibrium::Equilibrium(const Solid& solid, const TipContact& contact, const FreeMotion& motion,
                         FreeMotion touched, SymmetricMatrix matrix, SymmetricMatrix contact_matrix,
                         SparseFactor factor)
    : solid_(&solid),
      contact_(&contact),
      motion_(&motion),
      touched_(std::move(touched)),
      matrix_(std::move(matrix)),
      contact_matrix_(std::move(contact_matrix)),
      factor_(std::move(factor)) {}

Expected<Equilibrium> Equilibrium::prepare(const TetMesh& mesh, const Solid& solid, const TipContact& contact,
                                           const FreeMotion& motion) {
  auto matrix = stiffness_pattern(mesh, motion);
  auto touched = touched_part(mesh, contact, motion);
  auto factor = SparseFactor::analyse(matrix, touched_equations(contact, touched, motion));
  if (!factor) return tl::unexpected(factor.error());
  auto contact_matrix = stiffness_pattern(mesh, touched);
  return Equilibrium(solid, contact, motion, std::move(touched), std::move(matrix), std::move(contact_matrix),
                     std::move(*factor));
}

void Equilibrium::add_contact(const RigidTip& tip, const Eigen::VectorXd& u, bool curved, double share,
                              Eigen::MatrixXd& dense) {
  std::fill(contact_matrix_.values.begin(), contact_matrix_.values.end(), 0.0);
  contact_->add_stiffness(tip, u, touched_, curved, contact_matrix_, share);
  add_to_dense(contact_matrix_, dense);
}

Expected<void> Equilibrium::linearise(const RigidTip& tip, const Eigen::VectorXd& u) {
  std::fill(matrix_.values.begin(), matrix_.values.end(), 0.0);
  solid_->add_stiffness(u, *motion_, matrix_);
  contact_->add_stiffness(tip, u, *motion_, false, matrix_, kHeld);
  held_ = Eigen::MatrixXd::Zero(touched_.count(), touched_.count());
  add_contact(tip, u, false, kHeld, held_);
  held_ = held_.selfadjointView<Eigen::Lower>();
  auto done = condense();
  // What is unstable all the same gets a stiffer diagonal: the step is one that descends.
  for (double share = 1e-3; !done && done.error().code != ErrorCode::exhausted && share <= 10.0;
       share *= 10.0) {
    stiffen_diagonal(share, matrix_);
    done = condense();
  }
  if (done) ++factorisations_;
  return done;
}

Expected<void> Equilibrium::condense() {
  if (auto done = factor_.factorise(matrix_); !done) return done;
  factorised_ = factor_.condensed();
  if (Eigen::LLT<Eigen::MatrixXd>(factorised_).info() != Eigen::Success)
    return refused("equilibrium: the touched surface's stiffness is not positive definite");
  condensed_ = factorised_ - held_;
  return {};
}

Eigen::VectorXd Equilibrium::touch(const RigidTip& tip, const Eigen::VectorXd& u,
                                   const Eigen::VectorXd& pull) {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(pull.size()), moved = u;
  const auto energy = [&](const Eigen::VectorXd& at) {
    moved = u;
    touched_.add(at, 1.0, moved);
    return 0.5 * at.dot(condensed_ * at) + pull.dot(at) + contact_->energy(tip, moved);
  };
  double value = energy(y);
  for (int step = 0; step < kMostTouches; ++step) {
    Eigen::VectorXd pushes = Eigen::VectorXd::Zero(u.size());
    contact_->add_forces(tip, moved, pushes);
    const Eigen::VectorXd push = touched_.free_part(pushes), rest = -push - condensed_ * y - pull;
    if (rest.norm() <= kTouchTolerance * push.norm()) break;
    Eigen::MatrixXd stiffness = condensed_;
    add_contact(tip, moved, rest.norm() < kNear * push.norm(), 1.0, stiffness);
    Eigen::LLT<Eigen::MatrixXd> triangle(stiffness);
    if (triangle.info() != Eigen::Success) {
      stiffness = factorised_;  // positive definite
      add_contact(tip, moved, false, 1.0, stiffness);
      triangle.compute(stiffness);
    }
    const Eigen::VectorXd direction = triangle.solve(rest);
    double length = 1.0, next_value = energy(y + direction);
    for (int halving = 0; !(next_value < value) && halving < kHalvings; ++halving)
      next_value = energy(y + (length *= 0.5) * direction);
    if (!(next_value < value)) break;  // rounding is all that is left
    y += length * direction;
    value = next_value;
  }
  return y;
}

Expected<Eigen::VectorXd> Equilibrium::way(const RigidTip& tip, const Eigen::VectorXd& u,
                                           const Eigen::VectorXd& forces) {
  const auto left = factor_.condense(-motion_->free_part(forces));
  if (!left) return tl::unexpected(left.error());
  const auto moved = factor_.expand(touch(tip, u, -*left));
  if (!moved) return tl::unexpected(moved.error());
  Eigen::VectorXd all = Eigen::VectorXd::Zero(u.size());
  motion_->add(*moved, 1.0, all);
  return all;
}

Expected<void> Equilibrium::search(const RigidTip& tip, const Eigen::VectorXd& way,
                                   Eigen::VectorXd& u) const {
  const auto energy = [&](const Eigen::VectorXd& at) {
    return solid_->energy(at) + contact_->energy(tip, at);
  };
  const double value = energy(u);
  double length = 1.0;
  for (int halving = 0; halving <= kHalvings; ++halving, length *= 0.5) {
    Eigen::VectorXd next = u + length * way;
    if (energy(next) <= value * (1.0 + 1e-10)) {
      u = std::move(next);
      return {};
    }
  }
  return refused("equilibrium: no descent");
}

Expected<int> Equilibrium::solve(const RigidTip& tip, const NewtonSettings& settings, Eigen::VectorXd& u) {
  bool fresh = false;
  double before = 0.0;
  for (int step = 0; step <= settings.most_steps; ++step) {
    const Eigen::VectorXd forces = solid_->forces(u);
    Eigen::VectorXd pushed = Eigen::VectorXd::Zero(u.size());
    contact_->add_forces(tip, u, pushed);
    const double scale = motion_->free_part(pushed).norm(), rest = motion_->free_part(forces + pushed).norm();
    if (rest <= settings.tolerance * scale) return step;
    const bool slow = step > 0 && rest > kSlow * before;
    if (condensed_.size() == 0 || (slow && !fresh)) {
      if (auto done = linearise(tip, u); !done) return tl::unexpected(done.error());
      fresh = true;
    } else {
      fresh = false;
    }
    before = rest;
    const auto step_way = way(tip, u, forces);
    if (!step_way) return tl::unexpected(step_way.error());
    if (auto found = search(tip, *step_way, u); !found) {
      if (fresh) return tl::unexpected(found.error());
      before = 0.0;  // a new factor, then
    }
  }
  return refused("equilibrium: {:.2g} N are left over after {} steps", before, settings.most_steps);
}

}  // namespace palpate::physics::deformable
