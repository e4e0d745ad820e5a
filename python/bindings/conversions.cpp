#include "python/bindings/conversions.h"

#include <algorithm>

namespace palpate::python {
namespace {

const char* code_name(ErrorCode code) {
  switch (code) {
    case ErrorCode::no_more:
      return "no_more";
    case ErrorCode::out_of_reach:
      return "out_of_reach";
    case ErrorCode::timed_out:
      return "timed_out";
    case ErrorCode::not_found:
      return "not_found";
    case ErrorCode::in_use:
      return "in_use";
    case ErrorCode::exhausted:
      return "exhausted";
    case ErrorCode::disconnected:
      return "disconnected";
    case ErrorCode::stopped:
      return "stopped";
    case ErrorCode::unspecified:
      break;
  }
  return "unspecified";
}

void translate(std::exception_ptr thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Failure& failure) {
    const py::module_ refusals = py::module_::import("palpate._refused");
    const bool refused = failure.error.kind == Error::Kind::refused;
    const py::object exception = refusals.attr(refused ? "refusal" : "wrong_use")(
        failure.error.message, code_name(failure.error.code));
    PyErr_SetObject(py::type::of(exception).ptr(), exception.ptr());
  }
}

}  // namespace

void raise_failures() { py::register_local_exception_translator(translate); }

py::array read_only(py::array array) {
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

std::vector<double> numbers_of(const Doubles& array) { return {array.data(), array.data() + array.size()}; }

std::vector<Vector3> points_of(const Doubles& rows) {
  std::vector<Vector3> points;
  const double* at = rows.data();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i, at += 3) points.emplace_back(at[0], at[1], at[2]);
  return points;
}

std::vector<Matrix3> matrices_of(const Doubles& array) {
  std::vector<Matrix3> matrices;
  const double* at = array.data();
  for (py::ssize_t i = 0; i < array.shape(0); ++i, at += 9)
    matrices.push_back(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(at));
  return matrices;
}

std::vector<Quaternion> quaternions_of(const Doubles& rows) {
  std::vector<Quaternion> rotations;
  const double* at = rows.data();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i, at += 4) rotations.emplace_back(at[0], at[1], at[2], at[3]);
  return rotations;
}

std::optional<Vector3> point_of(const std::optional<Doubles>& row) {
  if (!row) return std::nullopt;
  return Vector3(row->data()[0], row->data()[1], row->data()[2]);
}

std::vector<device::StampedPose> poses_of(const Doubles& positions, const Doubles& quaternions,
                                          const std::optional<Doubles>& time_s) {
  const auto places = points_of(positions);
  const auto rotations = quaternions_of(quaternions);
  std::vector<device::StampedPose> poses;
  for (std::size_t i = 0; i < places.size(); ++i) {
    device::StampedPose pose;
    pose.time_s = time_s ? time_s->data()[i] : static_cast<double>(i);
    pose.rotation = rotations[i];
    pose.translation = places[i];
    poses.push_back(pose);
  }
  return poses;
}

py::array array_of(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  Doubles array({matrix.rows(), matrix.cols()});
  double* to = array.mutable_data();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) *to++ = matrix(i, j);
  return read_only(std::move(array));
}

py::array list_of(const Eigen::Ref<const Eigen::VectorXd>& vector) {
  Doubles array(vector.size());
  for (Eigen::Index i = 0; i < vector.size(); ++i) array.mutable_data()[i] = vector[i];
  return read_only(std::move(array));
}

py::array rows_of(const std::vector<Vector3>& points) {
  Doubles array({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  double* to = array.mutable_data();
  for (const auto& point : points)
    for (int i = 0; i < 3; ++i) *to++ = point[i];
  return read_only(std::move(array));
}

py::array quaternion_rows(const std::vector<Quaternion>& rotations) {
  Doubles array({static_cast<py::ssize_t>(rotations.size()), py::ssize_t{4}});
  double* to = array.mutable_data();
  for (const auto& q : rotations)
    for (const double number : {q.w(), q.x(), q.y(), q.z()}) *to++ = number;
  return read_only(std::move(array));
}

py::array flags_of(const std::vector<bool>& flags) {
  py::array_t<bool> array(static_cast<py::ssize_t>(flags.size()));
  for (std::size_t i = 0; i < flags.size(); ++i) array.mutable_data()[i] = flags[i];
  return read_only(std::move(array));
}

py::array numbers_array(const std::vector<double>& numbers) {
  Doubles array(static_cast<py::ssize_t>(numbers.size()));
  std::copy(numbers.begin(), numbers.end(), array.mutable_data());
  return read_only(std::move(array));
}

py::array pose_matrix(const Quaternion& rotation, const Vector3& translation) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = translation;
  return array_of(matrix);
}

py::object object_of(const Json& json) {
  if (json.is_object()) {
    py::dict dict;
    for (const auto& [key, value] : json.items()) dict[py::str(key)] = object_of(value);
    return dict;
  }
  if (json.is_array()) {
    py::list list;
    for (const auto& value : json) list.append(object_of(value));
    return list;
  }
  if (json.is_string()) {  // bytes of people's labels that are no UTF-8: as write_json has them
    const auto& text = json.get_ref<const std::string&>();
    return py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "replace"));
  }
  if (json.is_boolean()) return py::bool_(json.get<bool>());
  if (json.is_number_unsigned()) return py::int_(json.get<std::uint64_t>());
  if (json.is_number_integer()) return py::int_(json.get<std::int64_t>());
  if (json.is_number_float()) return py::float_(json.get<double>());
  return py::none();
}

}  // namespace palpate::python
