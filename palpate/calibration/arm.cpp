#include "palpate/calibration/arm.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "palpate/calibration/arm_problem.h"
#include "palpate/calibration/robust_scale.h"
#include "palpate/estimation/linear_algebra.h"

namespace palpate {
namespace {

constexpr double kAlternatingChange = 1e-4;  // relative, system bar B4
constexpr int kAlternatingRounds = 50;
// Where an encoder zero may be when the arm was reset in an odd position, rad (40 deg): starts for offsets 2
// and 3.
constexpr double kResetStart = 0.7;

Expected<void> check(const std::vector<ArmObservation>& samples, const ArmModel& model,
                     const ArmOptions& options) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& s = samples[i];
    if (s.joints.size() != model.joint_count())
      return wrong_use("arm: sample {} has {} joint readings, {} has {} joints", i + 1, s.joints.size(),
                       model.name, model.joint_count());
    if (!s.joints.allFinite() || (s.tip && !s.tip->m.allFinite()) ||
        (s.marker && !(s.marker->translation.allFinite() && s.marker->rotation.coeffs().allFinite())))
      return refused("arm: sample {} is not finite; remove it", i + 1);
    if (!s.tip && !s.marker)
      return wrong_use("arm: sample {} has neither a measured tip nor a marker pose", i + 1);
  }
  if (options.free.dh && model.kind != ArmModel::Kind::dh)
    return wrong_use("arm: {} has no Denavit-Hartenberg rows to free; use lengths", model.name);
  return {};
}

bool all_have_markers(const std::vector<ArmObservation>& samples) {
  return std::all_of(samples.begin(), samples.end(), [](const auto& s) { return s.marker.has_value(); });
}

bool all_have_tips(const std::vector<ArmObservation>& samples) {
  return std::all_of(samples.begin(), samples.end(), [](const auto& s) { return s.tip.has_value(); });
}

ArmSolution nominal_arm(const ArmModel& model) {
  ArmSolution arm;
  arm.model = model;
  arm.gain = Eigen::VectorXd::Ones(model.joint_count());
  arm.offset = Eigen::VectorXd::Zero(model.joint_count());
  return arm;
}

// What a solve works on: samples, start, and what the tip is.
struct Setting {
  std::vector<WeighedSample> samples;
  ArmSolution nominal;     // placed in the world by its nominal values
  bool tip_free = false;   // estimated with the rest
  bool tip_found = false;  // not given: found by the linear start
};

Expected<Setting> prepare(const std::vector<ArmObservation>& observations, const ArmModel& model,
                          const ArmOptions& options) {
  if (const auto fine = check(observations, model, options); !fine) return tl::unexpected(fine.error());
  Setting setting;
  const bool markers = all_have_markers(observations), tips = all_have_tips(observations);
  const bool wants_tip = options.method == ArmMethod::joint && options.free.tip && markers;
  setting.tip_free = wants_tip;
  if (!tips && !markers)
    return wrong_use("arm: some samples have a marker pose, others a measured tip; give one kind");
  setting.nominal = nominal_arm(model);
  const bool use_markers = markers && (wants_tip || options.tip || !tips);
  if (use_markers) {
    setting.nominal.tip_known = true;
    setting.tip_found = !options.tip;
    if (options.tip) setting.nominal.tip_in_marker = *options.tip;
  }
  double mean_variance = 0.0;
  for (const auto& o : observations) {
    WeighedSample sample{&o, Matrix3::Identity(), 1.0};
    if (o.covariance && options.method == ArmMethod::joint) {
      Eigen::MatrixXd L;
      lower_cholesky(*o.covariance, L);
      sample.whitening = Matrix3(L).inverse();
      mean_variance += o.covariance->trace() / 3.0 / static_cast<double>(observations.size());
    }
    setting.samples.push_back(sample);
  }
  for (auto& sample : setting.samples)  // back to metres, so that scales stay readable
    if (sample.observation->covariance && options.method == ArmMethod::joint)
      sample.whitening *= std::sqrt(mean_variance);
  const std::size_t needed = 6;
  if (observations.size() < needed)
    return refused("arm: {} samples; at least {} are needed", observations.size(), needed);
  const auto placed = place_arm(setting.samples, setting.nominal, setting.tip_found,
                                model.kind == ArmModel::Kind::dh && !model.tool_known);
  if (!placed) return tl::unexpected(placed.error());
  setting.nominal = *placed;
  return setting;
}

std::vector<Vector3> whitened_residuals(const std::vector<WeighedSample>& samples, const ArmSolution& arm) {
  std::vector<Vector3> residuals;
  for (const auto& s : samples)
    residuals.push_back(s.whitening * arm_residual(arm, *s.observation, {}, nullptr));
  return residuals;
}

// The best of several starts of a PHANToM's offsets 2 and 3: encoders that were zeroed in an odd position.
ArmSolution best_start(const Setting& setting, const std::vector<ArmParameter>& parameters) {
  struct Candidate {
    ArmSolution arm;
    double cost;
  };
  std::vector<Candidate> candidates;
  for (double second : {0.0, -kResetStart, kResetStart}) {
    for (double third : {0.0, -kResetStart, kResetStart}) {
      ArmSolution start = setting.nominal;
      start.offset[1] = second;
      start.offset[2] = third;
      const auto placed = place_arm(setting.samples, start, setting.tip_found, false);
      if (!placed) continue;
      candidates.push_back({*placed, solve_arm(setting.samples, *placed, {}, setting.nominal, 0.0).cost});
    }
  }
  if (candidates.empty()) return setting.nominal;
  std::stable_sort(candidates.begin() + 1, candidates.end(),
                   [](const auto& a, const auto& b) { return a.cost < b.cost; });
  Candidate best{setting.nominal, std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < std::min<std::size_t>(4, candidates.size()); ++i) {
    const auto fit = solve_arm(setting.samples, candidates[i].arm, parameters, setting.nominal, 1e-3, 30);
    // a later start must be clearly better: equal basins keep the nominal one
    if (fit.cost < (i == 0 ? 1.0 : 0.99) * best.cost) best = {fit.solution, fit.cost};
  }
  return best.arm;
}

ArmFreedom freedom_of(const ArmOptions& options, const ArmModel& model) {
  ArmFreedom freedom;
  const bool dh = model.kind == ArmModel::Kind::dh;
  freedom.base = true;
  freedom.gains = options.free.gains || options.free.dh;
  freedom.offsets = options.free.offsets || options.free.dh;
  freedom.lengths = options.free.lengths || options.free.dh;
  freedom.alpha = options.free.dh;
  freedom.tool = dh && !model.tool_known;
  return freedom;
}

Expected<void> enough_samples(std::size_t samples, std::size_t parameters) {
  const std::size_t needed = (parameters + 2) / 3 + 1;
  if (samples < needed)
    return refused("arm: {} samples for {} unknowns; at least {} are needed, spread over the workspace",
                   samples, parameters, needed);
  return {};
}

bool is_base(const ArmParameter& parameter) {
  return parameter.part == ArmParameter::Part::base_rotation ||
         parameter.part == ArmParameter::Part::base_translation;
}

// Directions the data leave to the prior: singular values of the Jacobian, columns in units of what is
// plausible, rows in units of the noise, below 1. Each is named by its largest parts.
std::vector<std::string> name_unobservable(const Eigen::MatrixXd& J,
                                           const std::vector<ArmParameter>& parameters, double scale) {
  Eigen::VectorXd sizes(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k)
    sizes[static_cast<Eigen::Index>(k)] = parameters[k].size;
  const Eigen::MatrixXd scaled = J * sizes.asDiagonal() / scale;
  const auto svd = singular_values(scaled);
  std::vector<std::string> names;
  for (Eigen::Index k = 0; k < svd.values.size(); ++k) {
    if (svd.values[k] >= 1.0) continue;
    const Eigen::VectorXd v = svd.V.col(k).cwiseAbs();
    double largest = 0.0;
    for (std::size_t p = 0; p < parameters.size(); ++p)
      if (!is_base(parameters[p])) largest = std::max(largest, v[static_cast<Eigen::Index>(p)]);
    std::string name;
    for (std::size_t p = 0; p < parameters.size(); ++p)
      if (!is_base(parameters[p]) && v[static_cast<Eigen::Index>(p)] > 0.5 * largest)
        name += (name.empty() ? "" : "+") + parameters[p].name;
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

double condition_of(const Eigen::MatrixXd& J) {
  Eigen::VectorXd norms = J.colwise().norm().transpose();
  for (double& n : norms) n = n > 0.0 ? 1.0 / n : 0.0;
  const Eigen::VectorXd values = singular_values(J * norms.asDiagonal()).values;
  return values[0] / std::max(values[values.size() - 1], 1e-300);
}

// Covariance, condition and unobservable directions at the estimate, from samples whose weight is not zero.
void add_covariance(Estimate<ArmSolution>& estimate, const Setting& setting,
                    const std::vector<ArmParameter>& parameters) {
  const auto P = static_cast<Eigen::Index>(parameters.size());
  Eigen::MatrixXd J(3 * static_cast<Eigen::Index>(setting.samples.size()), P);
  Eigen::Matrix3Xd row(3, P);
  Eigen::Index rows = 0;
  double chi2 = 0.0;
  for (const auto& sample : setting.samples) {
    if (sample.weight == 0.0) continue;
    chi2 += (sample.whitening * arm_residual(estimate.value, *sample.observation, parameters, &row))
                .squaredNorm();
    J.middleRows<3>(rows) = sample.whitening * row;
    rows += 3;
  }
  J.conservativeResize(rows, P);
  const double sigma = std::max(kLeastScale, std::sqrt(chi2 / std::max(1.0, static_cast<double>(rows - P))));
  Eigen::MatrixXd information = J.transpose() * J / (sigma * sigma);
  for (Eigen::Index k = 0; k < P; ++k)
    if (!is_base(parameters[static_cast<std::size_t>(k)]))
      information(k, k) +=
          1.0 / (parameters[static_cast<std::size_t>(k)].size * parameters[static_cast<std::size_t>(k)].size);
  // scaled by its diagonal before inverting: the entries differ by many orders of magnitude
  const Eigen::VectorXd d = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = d.asDiagonal() * information * d.asDiagonal();
  estimate.covariance = d.asDiagonal() * inverse_symmetric(scaled) * d.asDiagonal();
  estimate.condition = condition_of(J);
  estimate.unobservable = name_unobservable(J, parameters, std::max(sigma, 1e-7));
  if (setting.nominal.model.kind == ArmModel::Kind::phantom)
    estimate.unobservable.insert(estimate.unobservable.begin(), "offset_1");
  estimate.value.parameters.clear();
  for (const auto& parameter : parameters) estimate.value.parameters.push_back(parameter.name);
}

Expected<Estimate<ArmSolution>> joint(Setting setting, const ArmOptions& options) {
  const ArmModel& model = setting.nominal.model;
  const bool phantom = model.kind == ArmModel::Kind::phantom;
  ArmFreedom freedom = freedom_of(options, model);
  freedom.first_offset = !phantom;
  freedom.tip = setting.tip_free;
  const auto parameters = list_parameters(model, freedom);
  if (const auto fine = enough_samples(setting.samples.size(), parameters.size()); !fine)
    return tl::unexpected(fine.error());
  const auto P = static_cast<double>(parameters.size());

  Estimate<ArmSolution> estimate;
  ArmSolution arm = phantom && options.free.offsets ? best_start(setting, parameters) : setting.nominal;
  double scale = 1e-3;  // m; replaced by the residuals' own after the first solve
  for (int round = 0; round < 40; ++round) {
    const auto fit = solve_arm(setting.samples, arm, parameters, setting.nominal, scale);
    const Vector3 before = arm.X_world_base.translation;
    const Eigen::VectorXd offset_before = arm.offset;
    arm = fit.solution;
    estimate.iterations += fit.iterations;
    const double last_scale = scale;
    const auto residuals = whitened_residuals(setting.samples, arm);
    scale = robust_scale(residuals, P);
    if (options.robust)
      for (std::size_t i = 0; i < residuals.size(); ++i)
        setting.samples[i].weight =
            round < 5 ? huber_weight(residuals[i].norm(), scale) : tukey_weight(residuals[i].norm(), scale);
    const double change =
        (arm.X_world_base.translation - before).norm() + 0.2 * (arm.offset - offset_before).norm();
    estimate.termination = Termination::iteration_limit;
    if (round >= 7 && (change < 1e-9 || change < 1e-4 * scale) &&
        std::abs(scale - last_scale) < 1e-3 * scale + 2 * kLeastScale) {
      estimate.termination = Termination::converged;
      break;
    }
  }

  // Covariance at the solution, inliers counting fully.
  std::size_t inliers = 0;
  for (auto& sample : setting.samples) {
    const bool inlier = sample.weight > 0.0;
    estimate.inlier.push_back(inlier);
    sample.weight = inlier ? 1.0 : 0.0;
    inliers += inlier;
  }
  if (const auto fine = enough_samples(inliers, parameters.size()); !fine)
    return refused(
        "arm: only {} of {} samples agree with one model of the arm ({} unknowns); check units and joint "
        "order",
        inliers, setting.samples.size(), parameters.size());
  estimate.value = std::move(arm);
  add_covariance(estimate, setting, parameters);
  return estimate;
}

Expected<Estimate<ArmSolution>> as_in_the_paper(const Setting& setting, const ArmOptions& options) {
  ArmFreedom freedom = freedom_of(options, setting.nominal.model);
  freedom.base = false;
  const auto parameters = list_parameters(setting.nominal.model, freedom);
  if (const auto fine = enough_samples(setting.samples.size(), parameters.size() + 6); !fine)
    return tl::unexpected(fine.error());
  Estimate<ArmSolution> estimate;
  ArmFit fit;
  if (options.method == ArmMethod::eq7) {
    fit = solve_arm_inside(setting.samples, setting.nominal, parameters);
    estimate.iterations = fit.iterations;
    estimate.termination = fit.converged ? Termination::converged : Termination::iteration_limit;
  } else {
    const int rounds = options.method == ArmMethod::one_pass ? 1 : kAlternatingRounds;
    estimate.termination =
        options.method == ArmMethod::one_pass ? Termination::converged : Termination::iteration_limit;
    fit.solution = setting.nominal;  // its base is the absolute orientation with nominal phi
    double last = std::numeric_limits<double>::infinity();
    for (int round = 0; round < rounds; ++round) {
      if (round > 0) {
        const auto placed = place_arm(setting.samples, fit.solution, false, false);
        if (!placed) return tl::unexpected(placed.error());
        fit.solution = *placed;
      }
      fit = solve_arm(setting.samples, fit.solution, parameters, setting.nominal, 0.0);
      estimate.iterations = round + 1;
      if (std::abs(last - fit.cost) < kAlternatingChange * fit.cost) {
        estimate.termination = Termination::converged;
        break;
      }
      last = fit.cost;
    }
  }
  estimate.value = std::move(fit.solution);
  freedom.base = true;
  freedom.first_offset = setting.nominal.model.kind != ArmModel::Kind::phantom;
  add_covariance(estimate, setting, list_parameters(setting.nominal.model, freedom));
  return estimate;
}

// Halves the samples' indices across the longest side until there are `parts` parts.
void halve(const std::vector<Vector3>& places, std::vector<std::size_t> indices, int parts,
           std::vector<std::vector<std::size_t>>& out) {
  if (parts <= 1) {
    out.push_back(std::move(indices));
    return;
  }
  Vector3 low = places[indices[0]], high = low;
  for (std::size_t i : indices) {
    low = low.cwiseMin(places[i]);
    high = high.cwiseMax(places[i]);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  std::stable_sort(indices.begin(), indices.end(),
                   [&](std::size_t a, std::size_t b) { return places[a][axis] < places[b][axis]; });
  const auto middle = indices.begin() + static_cast<std::ptrdiff_t>(indices.size() / 2);
  halve(places, {indices.begin(), middle}, parts / 2, out);
  halve(places, {middle, indices.end()}, parts - parts / 2, out);
}

}  // namespace

Point<World> predict_tip(const ArmSolution& arm, const Eigen::VectorXd& psi) {
  return arm.X_world_base * arm_tip(arm.model, arm.gain.cwiseProduct(psi) + arm.offset);
}

Point<World> measured_tip(const ArmSolution& arm, const ArmObservation& sample) {
  if (sample.marker && (arm.tip_known || !sample.tip))
    return *sample.marker * Point<TipMarker>{arm.tip_in_marker};
  return *sample.tip;
}

std::vector<Vector3> arm_errors(const ArmSolution& arm, const std::vector<ArmObservation>& samples) {
  std::vector<Vector3> errors;
  for (const auto& sample : samples)
    errors.push_back((measured_tip(arm, sample) - predict_tip(arm, sample.joints)).v);
  return errors;
}

Expected<Estimate<ArmSolution>> calibrate_arm(const std::vector<ArmObservation>& samples,
                                              const ArmModel& model, const ArmOptions& options) {
  auto setting = prepare(samples, model, options);
  if (!setting) return tl::unexpected(setting.error());
  auto estimate =
      options.method == ArmMethod::joint ? joint(*setting, options) : as_in_the_paper(*setting, options);
  if (estimate) estimate->residuals = arm_errors(estimate->value, samples);
  return estimate;
}

Expected<Estimate<ArmSolution>> uncorrected_arm(const std::vector<ArmObservation>& samples,
                                                const ArmModel& model, const ArmOptions& options) {
  ArmOptions plain = options;
  plain.free.dh = false;
  const auto setting = prepare(samples, model, plain);
  if (!setting) return tl::unexpected(setting.error());
  Estimate<ArmSolution> estimate;
  estimate.value = setting->nominal;
  estimate.residuals = arm_errors(estimate.value, samples);
  return estimate;
}

Expected<std::vector<double>> held_out_by_region(const std::vector<ArmObservation>& samples,
                                                 const ArmModel& model, const ArmOptions& options,
                                                 int regions) {
  const auto first = uncorrected_arm(samples, model, options);
  if (!first) return tl::unexpected(first.error());
  std::vector<Vector3> places;
  for (const auto& sample : samples) places.push_back(measured_tip(first->value, sample).m);
  std::vector<std::size_t> all(samples.size());
  std::iota(all.begin(), all.end(), 0u);
  std::vector<std::vector<std::size_t>> parts;
  halve(places, all, regions, parts);
  std::vector<double> means;
  for (const auto& part : parts) {
    std::vector<ArmObservation> training, test;
    for (std::size_t i = 0; i < samples.size(); ++i)
      (std::find(part.begin(), part.end(), i) == part.end() ? training : test).push_back(samples[i]);
    if (test.empty()) continue;
    const auto estimate = calibrate_arm(training, model, options);
    if (!estimate) return tl::unexpected(estimate.error());
    means.push_back(mean_norm(arm_errors(estimate->value, test)));
  }
  return means;
}

}  // namespace palpate
