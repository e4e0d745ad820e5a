// Numbers as a rig's file has them, in the file's units.
#pragma once

#include <Eigen/Core>
#include <string>

#include "palpate/math/so3.h"

namespace palpate::rig {

// `value` times `unit`. What that product is off by its own rounding is not written down: 209.55 mm stands there
// as 209.55, if that reads back as `value` to the bit, multiplied by 1 / unit as a rig's numbers are. A `value` that came
// from a file always does: a session is executed again with the rig that its recording holds.
std::string number_text(double value, double unit = 1.0);
std::string number_list(const Eigen::Ref<const Eigen::VectorXd>& v, double unit = 1.0);
std::string number_list(const Quaternion& q);  // w, x, y, z
std::string number_rows(const Eigen::Ref<const Eigen::MatrixXd>& m, double unit = 1.0);

}  // namespace palpate::rig
