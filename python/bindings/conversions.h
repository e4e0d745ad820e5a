// Between numpy's arrays and the library's values, and from the library's errors to Python's exceptions.
//
// The Python side (palpate/_arguments.py) has checked shapes, types and units before anything arrives here: arrays are
// float64 or int64, in C order, with as many columns as are read. What goes out is a copy that nobody may write to.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/device/pose_file.h"
#include "palpate/math/estimate.h"
#include "palpate/math/pose.h"

namespace palpate::python {

namespace py = pybind11;

using Doubles = py::array_t<double, py::array::c_style>;
using Integers = py::array_t<std::int64_t, py::array::c_style>;

// Becomes palpate.Refused or ValueError, as palpate/_refused.py has it; needs raise_failures() once in a module.
struct Failure {
  Error error;
};
void raise_failures();

template <typename T>
T value_or_raise(Expected<T>&& result) {
  if (!result) throw Failure{result.error()};
  return std::move(*result);
}

// Runs what takes time without the interpreter's lock: other threads go on.
template <typename Work>
auto unlocked(Work&& work) {
  const py::gil_scoped_release release;
  return work();
}

// Arrays in.
std::vector<double> numbers_of(const Doubles& array);
std::vector<Vector3> points_of(const Doubles& rows);                 // N x 3
std::vector<Matrix3> matrices_of(const Doubles& array);              // N x 3 x 3
std::vector<Quaternion> quaternions_of(const Doubles& rows);         // N x 4, w x y z
std::optional<Vector3> point_of(const std::optional<Doubles>& row);  // 3
// Without times the numbers of the rows are the times.
std::vector<device::StampedPose> poses_of(const Doubles& positions, const Doubles& quaternions,
                                          const std::optional<Doubles>& time_s);

// Arrays out, not to be written to.
py::array read_only(py::array array);
py::array array_of(const Eigen::Ref<const Eigen::MatrixXd>& matrix);  // N x M
py::array list_of(const Eigen::Ref<const Eigen::VectorXd>& vector);   // N
py::array rows_of(const std::vector<Vector3>& points);                // N x 3
py::array quaternion_rows(const std::vector<Quaternion>& rotations);  // N x 4, w x y z
py::array flags_of(const std::vector<bool>& flags);
py::array numbers_array(const std::vector<double>& numbers);
py::array pose_matrix(const Quaternion& rotation, const Vector3& translation);  // 4 x 4
template <typename A, typename B>
py::array pose_matrix(const Pose<A, B>& pose) {
  return pose_matrix(pose.rotation, pose.translation);
}

// Dicts and lists, in JSON's order of keys, numbers to the last bit.
py::object object_of(const Json& json);

// What every estimate says of itself: json, covariance, residuals, inliers, condition, unobservable, converged.
template <typename T>
py::dict estimate_fields(const Estimate<T>& estimate, const Json& json) {
  py::dict fields;
  fields["json"] = object_of(json);
  fields["covariance"] = array_of(estimate.covariance);
  fields["residuals"] = rows_of(estimate.residuals);
  fields["inliers"] = flags_of(estimate.inlier.empty() ? std::vector<bool>(estimate.residuals.size(), true)
                                                       : estimate.inlier);
  fields["condition"] = estimate.condition;
  fields["unobservable"] = estimate.unobservable;
  fields["converged"] = estimate.termination != Termination::iteration_limit;
  return fields;
}

}  // namespace palpate::python
