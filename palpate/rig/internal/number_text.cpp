#include "palpate/rig/internal/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "palpate/core/toml.h"

namespace palpate::rig {

std::string number_text(double value, double unit) {
  const double exact = unit * value;
  if (unit == 1.0 || !std::isfinite(exact)) return toml_number(exact);
  constexpr double kUp = std::numeric_limits<double>::infinity();
  const double shorter = std::strtod(fmt::format("{:.15g}", exact).c_str(), nullptr);
  const std::array candidates{shorter, exact, std::nextafter(exact, kUp), std::nextafter(exact, -kUp)};
  const auto* found = std::find_if(candidates.begin(), candidates.end(),
                                   [&](double text) { return text * (1.0 / unit) == value; });
  return toml_number(found == candidates.end() ? exact : *found);
}

std::string number_list(const Eigen::Ref<const Eigen::VectorXd>& v, double unit) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < v.size(); ++i) text += (i > 0 ? ", " : "") + number_text(v[i], unit);
  return text + "]";
}

std::string number_list(const Quaternion& q) {
  return number_list(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()));
}

std::string number_rows(const Eigen::Ref<const Eigen::MatrixXd>& m, double unit) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    text += (i > 0 ? ",\n  " : "\n  ") + number_list(m.row(i).transpose(), unit);
  return text + "\n]";
}

}  // namespace palpate::rig
