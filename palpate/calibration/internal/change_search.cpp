#include "palpate/calibration/internal/change_search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/math/chi_square.h"
#include "palpate/math/levenberg_marquardt.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr double kChangeStep = 1e-4;  // of a change's usual size, for derivatives
// A change that moves no prediction by a deviation over this many times its usual size cannot be told from these data.
constexpr double kLeastInformation = 1e-2;

double log_determinant(const Eigen::MatrixXd& A) {
  return math::symmetric_eigenvalues(A).cwiseMax(1e-300).array().log().sum();
}

Eigen::MatrixXd by_changes(const RigMisfit& misfit, const std::vector<Change>& changes,
                           const Eigen::VectorXd& at) {
  return derivative(at.size(), kChangeStep, [&](const Eigen::VectorXd& step) {
    return misfit.differences(changed(misfit.rig_state(), changes, at + step));
  });
}

Eigen::Index numbers_of(const RigMisfit& misfit, Change change) {
  return change_sizes(change, misfit.rig_state()).size();
}

FoundChange told_of(const RigMisfit& misfit, const ChangeFit& fit, std::size_t which, double fall,
                    double scale) {
  FoundChange found;
  found.change = fit.changes[which];
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < which; ++i) at += numbers_of(misfit, fit.changes[i]);
  const Eigen::VectorXd sizes = change_sizes(found.change, misfit.rig_state());
  found.amount = fit.amounts.segment(at, sizes.size()).cwiseProduct(sizes);
  const Eigen::MatrixXd C = math::covariance_from_information(misfit.product(fit.jacobian, fit.jacobian));
  found.covariance =
      scale * (sizes.asDiagonal() * C.block(at, at, sizes.size(), sizes.size()) * sizes.asDiagonal());
  found.fall = fall / scale;
  found.probability = chi_square_tails(found.fall, static_cast<double>(sizes.size())).above;
  found.evidence = found.fall - fit.occam;
  return found;
}

constexpr std::array<Change, kChanges> kAllChanges{
    Change::camera,  Change::lens,  Change::base,    Change::encoder_zero, Change::stylus_marker,
    Change::pointer, Change::table, Change::tracker, Change::camera_delay, Change::tracker_delay};

}  // namespace

RigState changed(const RigState& at, const std::vector<Change>& changes, const Eigen::VectorXd& amounts) {
  RigState state = at;
  Eigen::Index row = 0;
  for (const Change change : changes) {
    const Eigen::VectorXd sizes = change_sizes(change, state);
    state = with_change(state, change, amounts.segment(row, sizes.size()).cwiseProduct(sizes));
    row += sizes.size();
  }
  return state;
}

ChangeFit fit_changes(const RigMisfit& misfit, const std::vector<Change>& changes,
                      const Eigen::VectorXd& start) {
  ChangeFit fit;
  fit.changes = changes;
  fit.amounts = start;
  const auto evaluate = [&](const Eigen::VectorXd& at, NormalEquations<Eigen::Dynamic>* equations) {
    const Eigen::VectorXd e = misfit.differences(changed(misfit.rig_state(), changes, at));
    if (equations) {
      const Eigen::MatrixXd J = by_changes(misfit, changes, at);
      equations->JtJ = misfit.product(J, J);
      equations->Jtr = misfit.product(J, e);
    }
    return misfit.product(e, e)(0, 0);
  };
  const auto moved = [](const Eigen::VectorXd& at, const Eigen::VectorXd& step) -> Eigen::VectorXd {
    return at + step;
  };
  constexpr LeastSquaresOptions kFew{.most_iterations = 12, .tolerance = 1e-6};
  fit.cost =
      minimise_with(NormalEquations<Eigen::Dynamic>(start.size()), fit.amounts, evaluate, moved, kFew).cost;
  fit.jacobian = by_changes(misfit, changes, fit.amounts);
  // The determinant of the last change's own information, the others let free: by the ratio of two.
  const Eigen::Index last = changes.empty() ? 0 : numbers_of(misfit, changes.back());
  const Eigen::MatrixXd J = fit.jacobian, I = misfit.product(J, J);
  const auto with_prior = [](const Eigen::MatrixXd& A) -> Eigen::MatrixXd {
    return A + Eigen::MatrixXd::Identity(A.rows(), A.cols());
  };
  const Eigen::Index before = I.rows() - last;
  fit.occam = log_determinant(with_prior(I)) -
              (before > 0 ? log_determinant(with_prior(I.topLeftCorner(before, before))) : 0.0);
  return fit;
}

ChangeSearch search_changes(const RigMisfit& misfit, const VerificationOptions& options) {
  ChangeSearch search;
  const Eigen::VectorXd e = misfit.differences(misfit.rig_state());
  search.found.cost = misfit.product(e, e)(0, 0);
  search.found.jacobian.resize(misfit.rows(), 0);
  const double per_test = options.false_alarm / kChanges;
  for (int round = 0; round < options.most_changes; ++round) {
    std::vector<ChangeFit> fits;
    for (const Change change : kAllChanges) {
      std::vector<Change> changes = search.found.changes;
      if (std::find(changes.begin(), changes.end(), change) != changes.end()) continue;
      changes.push_back(change);
      const Eigen::Index n = numbers_of(misfit, change);
      Eigen::VectorXd start = Eigen::VectorXd::Zero(search.found.amounts.size() + n);
      start.head(search.found.amounts.size()) = search.found.amounts;
      const Eigen::MatrixXd J = by_changes(misfit, {change}, Eigen::VectorXd::Zero(n));
      if (!(misfit.product(J, J).diagonal().minCoeff() > kLeastInformation)) continue;
      fits.push_back(fit_changes(misfit, changes, start));
    }
    if (fits.empty()) break;
    // The noise is as large as the best of them leaves it, and not smaller than stated.
    double scale = 1.0;
    const auto best_fit = std::min_element(
        fits.begin(), fits.end(), [](const ChangeFit& a, const ChangeFit& b) { return a.cost < b.cost; });
    const double freedoms = static_cast<double>(misfit.rows() - best_fit->amounts.size());
    if (freedoms > 0.0) scale = std::max(1.0, best_fit->cost / freedoms);
    std::optional<FoundChange> best;
    const ChangeFit* chosen = nullptr;
    for (const auto& fit : fits) {
      FoundChange found = told_of(misfit, fit, fit.changes.size() - 1, search.found.cost - fit.cost, scale);
      if (round == 0) search.tried.push_back(found);
      if (found.probability > per_test) continue;
      if (best && best->evidence >= found.evidence) continue;
      best = found;
      chosen = &fit;
    }
    if (!best) break;
    search.found = *chosen;
    search.told.push_back(*best);
  }
  return search;
}

}  // namespace palpate::calibration
