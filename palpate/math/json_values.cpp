#include "palpate/math/json_values.h"

namespace palpate::inline math {

Json json_list(const Eigen::Ref<const Eigen::VectorXd>& vector, double scale) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < vector.size(); ++i) list.push_back(scale * vector[i]);
  return list;
}

Json json_rows(const Eigen::Ref<const Eigen::MatrixXd>& matrix, double scale) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    rows.push_back(json_list(matrix.row(i).transpose(), scale));
  return rows;
}

Json json_quaternion(const Quaternion& rotation) {
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
  return Json::array({sign * rotation.w(), sign * rotation.x(), sign * rotation.y(), sign * rotation.z()});
}

Json json_covariance(const std::vector<std::string>& names, const Eigen::MatrixXd& covariance,
                     const Eigen::VectorXd& scales) {
  const Eigen::MatrixXd scaled = scales.asDiagonal() * covariance * scales.asDiagonal();
  return Json{{"order", names}, {"matrix", json_rows(scaled)}};
}

Eigen::VectorXd standard_deviations(const Eigen::MatrixXd& covariance) {
  return covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

}  // namespace palpate::inline math
