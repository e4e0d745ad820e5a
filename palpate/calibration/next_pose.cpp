#include "palpate/calibration/next_pose.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "palpate/calibration/internal/arm_problem.h"
#include "palpate/calibration/internal/arm_setting.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

// The unknowns that `joint` solves for, as far as `free` asks for them.
std::vector<ArmParameter> design_parameters(const device::ArmModel& model, const ArmFree& free) {
  ArmOptions options;
  options.free = free;
  ArmFreedom freedom = freedom_of(options, model);
  freedom.first_offset = model.kind == device::ArmModel::Kind::dh;
  freedom.tip = free.tip;
  return list_parameters(model, freedom);
}

}  // namespace

// One pose's part of the design.
struct DesignRow {
  Eigen::Matrix3Xd A;  // S^-1/2 J
  // What an error that near poses share does to J^T S^-1 r, per sd: shifts (three columns), and turns of the
  // marker on its lever (three).
  Eigen::Matrix<double, Eigen::Dynamic, 6> G;
  int own = 6;    // the last so many columns of G are not in S yet
  Vector3 place;  // World, of what errs together with its neighbours
};

// What is known after some poses: information, and the errors that they share.
struct DesignState {
  Eigen::MatrixXd information;
  Eigen::MatrixXd shared;  // sum over pairs of G_i G_j^T times their correlation
  std::vector<const DesignRow*> rows;
};

// A state made ready for trying candidates on it.
struct DesignTrial {
  const DesignState* state;
  Eigen::MatrixXd C, MC, Q, KC;  // C M C is Q
  double value = 0.0;
};

struct PoseDesign::Parts {
  ArmSolution arm;
  DesignOptions options;
  std::vector<ArmParameter> parameters;
  Eigen::MatrixXd M;  // mean of J_w^T J_w
  std::vector<std::unique_ptr<DesignRow>> taken;
  std::vector<DesignRow> candidates;
  DesignState state;
  bool shares = false;  // whether any pose's error is shared

  Eigen::Index size() const { return static_cast<Eigen::Index>(parameters.size()); }

  Eigen::Matrix3Xd jacobian_at(const Eigen::VectorXd& psi) const {
    device::ArmObservation
        place;  // without a marker: the tip in it has no part in where the arm says the tip is
    place.joints = psi;
    place.tip = Point<World>{Vector3::Zero()};
    Eigen::Matrix3Xd J(3, size());
    arm_residual(arm, place, parameters, &J);
    return J;
  }

  DesignRow row_of(const device::ArmObservation& pose) {
    device::ArmObservation seen = pose;
    if (!seen.marker && !seen.tip) seen.tip = predict_tip(arm, pose.joints);
    Eigen::Matrix3Xd J(3, size());
    arm_residual(arm, seen, parameters, &J);
    const Matrix3 S =
        pose.covariance ? *pose.covariance : Matrix3(options.sd * options.sd * Matrix3::Identity());
    Matrix3 W;
    if (!whitening(S, W)) throw std::invalid_argument("pose design: a covariance is not positive");
    DesignRow row;
    row.A = W * J;
    row.place = seen.marker ? seen.marker->translation : seen.tip->m;
    // A field that shifts by sd b within its length also turns, by about b / length.
    const bool stated = pose.systematic && pose.covariance;
    const double b = stated ? *pose.systematic / std::sqrt(3.0) : options.shared_sd;
    const Vector3 lever = seen.marker ? Vector3(seen.marker->rotation * arm.tip_in_marker) : Vector3::Zero();
    const Eigen::MatrixX3d V = (W.transpose() * row.A).transpose();  // J^T S^-1
    row.G.resize(size(), 6);
    row.G << b * V, (b / options.shared_length) * V * hat(lever);
    row.own = stated ? 3 : 6;
    shares = shares || (b > 0.0 && options.criterion == DesignCriterion::i_optimal);
    return row;
  }

  double correlation(const Vector3& a, const Vector3& b) const {
    return std::exp(-0.5 * (a - b).squaredNorm() / (options.shared_length * options.shared_length));
  }
  // Sum of the state's G, as far as they go with a row at `place`.
  Eigen::MatrixXd shared_with(const DesignState& at, const Vector3& place) const {
    Eigen::MatrixXd X = Eigen::MatrixXd::Zero(size(), 6);
    for (const auto* row : at.rows) X += correlation(row->place, place) * row->G;
    return X;
  }

  // Adds (sign +1) a row, or takes one away that is among the state's (-1).
  void change(DesignState& at, const DesignRow& row, double sign) const {
    if (sign < 0.0) at.rows.erase(std::find(at.rows.begin(), at.rows.end(), &row));
    at.information += sign * row.A.transpose() * row.A;
    if (shares) {
      const Eigen::MatrixXd X = shared_with(at, row.place);
      const auto own = row.G.rightCols(row.own);
      at.shared += sign * (own * own.transpose() + X * row.G.transpose() + row.G * X.transpose());
    }
    if (sign > 0.0) at.rows.push_back(&row);
  }

  Eigen::MatrixXd covariance(const DesignState& at) const {
    return covariance_from_information(at.information);
  }

  DesignTrial trial(const DesignState& at) const {
    DesignTrial t;
    t.state = &at;
    t.C = covariance(at);
    if (options.criterion == DesignCriterion::d_optimal) return t;
    t.MC = M * t.C;
    t.Q = t.C * t.MC;
    t.value = t.MC.trace();
    if (shares) {
      t.KC = at.shared * t.C;
      t.value += (t.Q.cwiseProduct(at.shared)).sum();
    }
    return t;
  }

  // How much smaller the criterion gets by one more row. With U = C A^T and H = (1 + A U)^-1 the covariance
  // becomes C - U H U^T (Sherman, Morrison, Woodbury), and everything else follows without another inverse.
  double gain(const DesignTrial& t, const DesignRow& row) const {
    const Eigen::MatrixX3d U = t.C * row.A.transpose();
    const Matrix3 inner = Matrix3::Identity() + row.A * U;
    if (options.criterion == DesignCriterion::d_optimal) return std::log(inner.determinant());
    const Matrix3 H = inner.inverse();
    const Eigen::MatrixX3d MU = t.MC * row.A.transpose();
    const Matrix3 N = U.transpose() * MU;
    double gain = (H * N).trace();
    if (!shares) return gain;
    // The shared part: trace(C' M C' K') with K' = K + own own^T + X G^T + G X^T.
    const Eigen::MatrixXd X = shared_with(*t.state, row.place);
    const auto own = row.G.rightCols(row.own);
    const Eigen::MatrixXd QG = t.Q * row.G;
    const double widened = own.cwiseProduct(QG.rightCols(row.own)).sum() + 2.0 * X.cwiseProduct(QG).sum();
    const Eigen::MatrixX3d KU = t.KC * row.A.transpose() + own * (own.transpose() * U) +
                                X * (row.G.transpose() * U) + row.G * (X.transpose() * U);
    const Eigen::MatrixX3d QA = t.Q * row.A.transpose();  // C M U
    const double mixed = (H * (QA.transpose() * KU)).trace();
    const double twice = (H * N * H * (U.transpose() * KU)).trace();
    return gain - widened + 2.0 * mixed - twice;
  }

  std::size_t best_on(const DesignState& at) const {
    const DesignTrial t = trial(at);
    std::size_t best = 0;
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const double g = gain(t, candidates[i]);
      if (g > most) {
        most = g;
        best = i;
      }
    }
    return best;
  }

  // What the criterion is worth, smaller is better.
  double value(const DesignState& at) const {
    if (options.criterion == DesignCriterion::i_optimal) return trial(at).value;
    double sum = 0.0;
    for (double v : symmetric_eigenvalues(at.information)) sum -= std::log(v);
    return sum;
  }

  // Mean square over the workspace `mean_square` (M, or J^T J of one place).
  double predicted(const DesignState& at, const Eigen::MatrixXd& mean_square) const {
    const Eigen::MatrixXd C = covariance(at);
    double square = (mean_square * C).trace();
    if (shares) square += (C * mean_square * C).cwiseProduct(at.shared).sum();
    return std::sqrt(std::max(0.0, square));
  }
};

PoseDesign::PoseDesign(const ArmSolution& arm, const std::vector<Eigen::VectorXd>& workspace,
                       std::vector<device::ArmObservation> candidates, const DesignOptions& options)
    : parts_(std::make_unique<Parts>()) {
  if (workspace.empty()) throw std::invalid_argument("pose design: no workspace to be good in");
  auto& p = *parts_;
  p.arm = arm;
  p.options = options;
  p.parameters = design_parameters(arm.model, options.free);
  const Eigen::Index P = p.size();
  p.M = Eigen::MatrixXd::Zero(P, P);
  for (const auto& psi : workspace) {
    const Eigen::Matrix3Xd J = p.jacobian_at(psi);
    p.M += J.transpose() * J / static_cast<double>(workspace.size());
  }
  p.state.information = Eigen::MatrixXd::Zero(P, P);
  p.state.shared = Eigen::MatrixXd::Zero(P, P);
  // The prior of `joint` on what is plausible; the base, which has none there, is held by as little (1 rad,
  // 1 m), so that a design may begin with no pose at all.
  for (Eigen::Index k = 0; k < P; ++k) {
    const double size = p.parameters[static_cast<std::size_t>(k)].size;
    p.state.information(k, k) = 1.0 / (size * size);
  }
  for (const auto& candidate : candidates) p.candidates.push_back(p.row_of(candidate));
}

PoseDesign::~PoseDesign() = default;
PoseDesign::PoseDesign(PoseDesign&&) noexcept = default;

void PoseDesign::take(const device::ArmObservation& pose) {
  parts_->taken.push_back(std::make_unique<DesignRow>(parts_->row_of(pose)));
  parts_->change(parts_->state, *parts_->taken.back(), 1.0);
}

std::size_t PoseDesign::best() const {
  if (parts_->candidates.empty()) throw std::invalid_argument("pose design: no candidates");
  return parts_->best_on(parts_->state);
}

std::vector<std::size_t> PoseDesign::plan(int count, int passes) const {
  const auto& p = *parts_;
  if (p.candidates.empty()) throw std::invalid_argument("pose design: no candidates");
  std::vector<std::size_t> chosen;
  DesignState at = p.state;
  for (int k = 0; k < count; ++k) {
    chosen.push_back(p.best_on(at));
    p.change(at, p.candidates[chosen.back()], 1.0);
  }
  // Each pose in turn is given up for the best there is without it.
  double value = p.value(at);
  for (int pass = 0; pass < passes; ++pass) {
    bool changed = false;
    for (auto& index : chosen) {
      DesignState without = at;
      p.change(without, p.candidates[index], -1.0);
      const std::size_t other = p.best_on(without);
      if (other == index) continue;
      p.change(without, p.candidates[other], 1.0);
      const double now = p.value(without);
      if (!(now < value - 1e-9 * std::abs(value))) continue;
      at = std::move(without);
      value = now;
      index = other;
      changed = true;
    }
    if (!changed) break;
  }
  // In the order in which they help most.
  std::vector<std::size_t> ordered, left = chosen;
  at = p.state;
  while (!left.empty()) {
    const DesignTrial t = p.trial(at);
    const auto best = std::max_element(left.begin(), left.end(), [&](std::size_t a, std::size_t b) {
      return p.gain(t, p.candidates[a]) < p.gain(t, p.candidates[b]);
    });
    ordered.push_back(*best);
    left.erase(best);
    p.change(at, p.candidates[ordered.back()], 1.0);
  }
  return ordered;
}

double PoseDesign::predicted_error() const { return parts_->predicted(parts_->state, parts_->M); }

double PoseDesign::predicted_error(const std::vector<std::size_t>& chosen) const {
  DesignState at = parts_->state;
  for (std::size_t index : chosen) parts_->change(at, parts_->candidates.at(index), 1.0);
  return parts_->predicted(at, parts_->M);
}

double PoseDesign::predicted_error_at(const Eigen::VectorXd& psi) const {
  const Eigen::Matrix3Xd J = parts_->jacobian_at(psi);
  return parts_->predicted(parts_->state, J.transpose() * J);
}

std::vector<Eigen::VectorXd> joint_grid(const std::vector<std::array<double, 2>>& ranges, int per_joint) {
  if (ranges.empty() || per_joint < 1) throw std::invalid_argument("joint grid: nothing to cover");
  std::vector<Eigen::VectorXd> grid{Eigen::VectorXd(static_cast<Eigen::Index>(ranges.size()))};
  for (std::size_t j = 0; j < ranges.size(); ++j) {
    std::vector<Eigen::VectorXd> finer;
    for (const auto& begun : grid)
      for (int k = 0; k < per_joint; ++k) {
        const double share = per_joint > 1 ? static_cast<double>(k) / (per_joint - 1) : 0.5;
        finer.push_back(begun);
        finer.back()[static_cast<Eigen::Index>(j)] = ranges[j][0] + share * (ranges[j][1] - ranges[j][0]);
      }
    grid = std::move(finer);
  }
  return grid;
}

}  // namespace palpate::calibration
