// Vectors, matrices and what a calibration says of its errors, as JSON.
//
// Every entry is multiplied by `scale`; a key or name carries its unit. Pure functions.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/math/so3.h"

namespace palpate::inline math {

Json json_list(const Eigen::Ref<const Eigen::VectorXd>& vector, double scale = 1.0);
Json json_rows(const Eigen::Ref<const Eigen::MatrixXd>& matrix, double scale = 1.0);
Json json_quaternion(const Quaternion& rotation);  // w, x, y, z with w >= 0
// {"order": names, "matrix": rows}; entry (i, j) is scaled by scales i and j.
Json json_covariance(const std::vector<std::string>& names, const Eigen::MatrixXd& covariance,
                     const Eigen::VectorXd& scales);
Eigen::VectorXd standard_deviations(const Eigen::MatrixXd& covariance);

}  // namespace palpate::inline math
