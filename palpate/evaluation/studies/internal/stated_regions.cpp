#include "palpate/evaluation/studies/internal/stated_regions.h"

#include <Eigen/LU>
#include <algorithm>
#include <stdexcept>

namespace palpate::evaluation::studies {
namespace {

// The covariance with its parameters in the order of the bound's derivatives.
Eigen::Matrix<double, kBoundSize, kBoundSize> in_bound_order(
    const Estimate<calibration::ArmSolution>& estimate) {
  constexpr std::array<std::string_view, kBoundSize> kNames{"base_rotation_x",
                                                            "base_rotation_y",
                                                            "base_rotation_z",
                                                            "base_translation_x",
                                                            "base_translation_y",
                                                            "base_translation_z",
                                                            "gain_1",
                                                            "gain_2",
                                                            "gain_3",
                                                            "offset_2",
                                                            "offset_3",
                                                            "tip_x",
                                                            "tip_y",
                                                            "tip_z"};
  const auto& names = estimate.value.parameters;
  std::array<Eigen::Index, kBoundSize> from{};
  for (std::size_t k = 0; k < kNames.size(); ++k) {
    const auto found = std::find(names.begin(), names.end(), kNames[k]);
    if (found == names.end() || names.size() != kNames.size())
      throw std::invalid_argument("study: regions are of the joint method with a free tip, lengths held");
    from[k] = found - names.begin();
  }
  Eigen::Matrix<double, kBoundSize, kBoundSize> C;
  for (Eigen::Index i = 0; i < kBoundSize; ++i)
    for (Eigen::Index j = 0; j < kBoundSize; ++j)
      C(i, j) = estimate.covariance(from[static_cast<std::size_t>(i)], from[static_cast<std::size_t>(j)]);
  return C;
}

}  // namespace

bool inside_region(const Vector3& error, const Matrix3& covariance) {
  return error.dot(covariance.inverse() * error) <= kChiSquared3At95;
}

double share_of_places_inside(const Estimate<calibration::ArmSolution>& estimate,
                              const ArmLaboratory& laboratory) {
  const auto& arm = estimate.value;
  const auto C = in_bound_order(estimate).topLeftCorner<kBoundTip, kBoundTip>().eval();
  const TrueArm believed{arm.model.lengths, {arm.gain, arm.offset}, arm.X_world_base};
  double inside = 0.0;
  for (std::size_t i = 0; i < laboratory.judged.size(); ++i) {
    const Vector3& psi = laboratory.judged[i];
    const Eigen::Matrix<double, 3, kBoundTip> J =
        tip_derivatives(believed, psi, Quaternion::Identity()).leftCols<kBoundTip>();
    const Vector3 error = calibration::predict_tip(arm, psi).m - laboratory.judged_place[i];
    if (inside_region(error, J * C * J.transpose())) inside += 1.0;
  }
  return inside / static_cast<double>(laboratory.judged.size());
}

bool tip_inside(const Estimate<calibration::ArmSolution>& estimate, const Vector3& true_tip) {
  const auto C = in_bound_order(estimate);
  return inside_region(estimate.value.tip_in_marker - true_tip, C.bottomRightCorner<3, 3>());
}

}  // namespace palpate::evaluation::studies
