#include "palpate/device/arm_kinematics.h"
#include "palpate/device/arm_samples.h"
#include "palpate/formats/tables.h"
#include "palpate/rig/rig.h"
#include "python/bindings/conversions.h"
#include "python/bindings/known_surface.h"
#include "python/bindings/module.h"

namespace palpate::python {
namespace {

// Positions and quaternions of 4 x 4 matrices; `name` is the argument's, for words.
py::tuple split_matrices(const Doubles& matrices, const std::string& name) {
  std::vector<Vector3> places;
  std::vector<Quaternion> rotations;
  for (py::ssize_t i = 0; i < matrices.shape(0); ++i) {
    const auto pose = value_or_raise(
        device::pose_from_matrix(std::span(matrices.data(i, 0, 0), 16), 1.0, fmt::format("{}[{}]", name, i)));
    places.push_back(pose.translation);
    rotations.push_back(pose.rotation);
  }
  return py::make_tuple(rows_of(places), quaternion_rows(rotations));
}

// N x 4 x 4.
py::array join_matrices(const Doubles& positions, const Doubles& quaternions) {
  const auto places = points_of(positions);
  const auto rotations = quaternions_of(quaternions);
  Doubles array({static_cast<py::ssize_t>(places.size()), py::ssize_t{4}, py::ssize_t{4}});
  double* to = array.mutable_data();
  for (std::size_t i = 0; i < places.size(); ++i, to += 16) {
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(to);
    matrix.setIdentity();
    matrix.topLeftCorner<3, 3>() = rotations[i].toRotationMatrix();
    matrix.topRightCorner<3, 1>() = places[i];
  }
  return array;
}

py::dict read_poses(const std::string& path, const std::string& transform, const std::string& segments) {
  const auto table = value_or_raise(unlocked(
      [&] { return formats::read_poses(path, {.transform = transform, .segment_column = segments}); }));
  const auto& file = table.file;
  std::vector<double> time_s;
  std::vector<Vector3> places;
  std::vector<Quaternion> rotations;
  py::list labels;
  for (const auto& pose : file.poses) {
    time_s.push_back(pose.time_s);
    places.push_back(pose.translation);
    rotations.push_back(pose.rotation);
    if (pose.segment < 0)
      labels.append(py::none());
    else
      labels.append(file.segments[static_cast<std::size_t>(pose.segment)]);
  }
  py::dict fields;
  fields["positions"] = rows_of(places);
  fields["quaternions"] = quaternion_rows(rotations);
  fields["time"] = file.has_time ? py::object(numbers_array(time_s)) : py::none();
  fields["segments"] = segments.empty() ? py::object(py::none()) : py::object(labels);
  return fields;
}

py::dict read_points(const std::string& path) {
  const auto table = value_or_raise(formats::read_points(path));
  const auto& file = table.file;
  py::dict fields;
  fields["points"] = rows_of(file.points);
  fields["labels"] = file.labels.empty() ? py::object(py::none()) : py::cast(file.labels);
  fields["weights"] = file.weights.empty() ? py::object(py::none()) : py::object(numbers_array(file.weights));
  return fields;
}

// A column of what all samples have; a column that only some have is left out, as the calibrations do.
template <typename Width, typename Fill>
void put_column(py::dict& fields, const char* name, const std::vector<device::ArmObservation>& samples,
                Width width, Fill fill) {
  Eigen::MatrixXd column(static_cast<Eigen::Index>(samples.size()), static_cast<Eigen::Index>(width));
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (!fill(samples[i], column.row(static_cast<Eigen::Index>(i)))) return;
  fields[name] = array_of(column);
}

py::dict read_arm_samples(const std::string& path) {
  const auto file = value_or_raise(unlocked([&] { return formats::read_arm_samples(path); }));
  const auto& samples = file.observations;
  using Sample = device::ArmObservation;
  py::dict fields;
  if (samples.empty()) return fields;
  const auto put = [&](const char* name, Eigen::Index width, auto fill) {
    put_column(fields, name, samples, width, fill);
  };
  put("joints", samples.front().joints.size(),
      [](const Sample& s, auto row) { return row = s.joints.transpose(), true; });
  put("gimbal", 3, [](const Sample& s, auto row) { return s.gimbal && (row = s.gimbal->transpose(), true); });
  put("time", 1, [](const Sample& s, auto row) { return s.time_s && (row[0] = *s.time_s, true); });
  put("tips", 3, [](const Sample& s, auto row) { return s.tip && (row = s.tip->m.transpose(), true); });
  put("targets", 3,
      [](const Sample& s, auto row) { return s.target && (row = s.target->m.transpose(), true); });
  put("systematic", 1,
      [](const Sample& s, auto row) { return s.systematic && (row[0] = *s.systematic, true); });
  put("marker_positions", 3,
      [](const Sample& s, auto row) { return s.marker && (row = s.marker->translation.transpose(), true); });
  put("marker_quaternions", 4, [](const Sample& s, auto row) {
    if (!s.marker) return false;
    const Quaternion& q = s.marker->rotation;
    row << q.w(), q.x(), q.y(), q.z();
    return true;
  });
  put("covariances", 9, [](const Sample& s, auto row) {
    for (Eigen::Index i = 0; s.covariance && i < 9; ++i) row[i] = (*s.covariance)(i / 3, i % 3);
    return s.covariance.has_value();
  });
  return fields;
}

py::dict rig_surface(const rig::SurfaceCalibration& surface) {
  py::dict fields;
  fields["name"] = surface.name;
  fields["pose"] = pose_matrix(surface.X_world_rectangle);
  fields["width"] = surface.width;
  fields["height"] = surface.height;
  fields["known"] = known_surface(surface);
  return fields;
}

// Poses of one frame in another that do not change while the arm moves.
py::dict rig_transforms(const rig::Rig& rig) {
  py::dict transforms;
  const auto put = [&](const std::string& parent, const std::string& child, const auto& pose) {
    transforms[py::make_tuple(parent, child)] = pose_matrix(pose);
  };
  if (rig.arm) {
    put("World", "ArmBase", rig.arm->X_world_base);
    const Quaternion turn = rig.arm->R_tip_marker.conjugate();
    put("TipMarker", "Tip", Pose<TipMarker, Tip>{turn, rig.arm->tip_in_marker});
  }
  if (rig.hand_eye) put("CameraMarker", "CameraOptical", rig.hand_eye->X_marker_camera);
  if (rig.right_hand_eye) put("CameraMarker", "RightCameraOptical", rig.right_hand_eye->X_marker_camera);
  if (rig.board) put("World", "Board", rig.board->X_world_board);
  for (const auto& surface : rig.surfaces) put("World", surface.name, surface.X_world_rectangle);
  return transforms;
}

class LoadedRig {
 public:
  explicit LoadedRig(const std::string& path)
      : rig_(value_or_raise(unlocked([&] { return rig::read_rig(path); }))) {
    if (rig_.arm) arm_ = device::make_kinematics(rig_.arm->model);
  }

  std::string text() const { return rig::rig_text(rig_); }
  py::dict transforms() const { return rig_transforms(rig_); }
  py::list surfaces() const {
    py::list surfaces;
    for (const auto& surface : rig_.surfaces) surfaces.append(rig_surface(surface));
    return surfaces;
  }
  py::ssize_t joint_count() const { return arm_ ? arm_->joint_count() : 0; }

  // N x 4 x 4: the stylus in World at these readings (N x joints, N x 3).
  py::array stylus(const Doubles& joints, const Doubles& gimbal) const {
    Doubles array({joints.shape(0), py::ssize_t{4}, py::ssize_t{4}});
    double* to = array.mutable_data();
    const auto turns = points_of(gimbal);
    for (py::ssize_t i = 0; i < joints.shape(0); ++i, to += 16) {
      const device::JointVector psi(Eigen::Map<const Eigen::VectorXd>(joints.data(i, 0), joints.shape(1)));
      const Vector3 corrected =
          rig_.arm->gimbal_gain.cwiseProduct(turns[static_cast<std::size_t>(i)]) + rig_.arm->gimbal_offset;
      const auto pose = rig_.arm->X_world_base * arm_->pose(rig_.arm->correction.apply(psi), corrected);
      Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(to);
      matrix.setIdentity();
      matrix.topLeftCorner<3, 3>() = pose.matrix();
      matrix.topRightCorner<3, 1>() = pose.translation;
    }
    return array;
  }

 private:
  rig::Rig rig_;
  std::unique_ptr<const device::ArmKinematics> arm_;
};

}  // namespace

void add_files(py::module_& module) {
  module.def("split_matrices", &split_matrices);
  module.def("join_matrices", &join_matrices);
  module.def("read_poses", &read_poses);
  module.def("read_points", &read_points);
  module.def("read_arm_samples", &read_arm_samples);
  py::class_<LoadedRig>(module, "Rig")
      .def(py::init<const std::string&>())
      .def("text", &LoadedRig::text)
      .def("transforms", &LoadedRig::transforms)
      .def("surfaces", &LoadedRig::surfaces)
      .def("joint_count", &LoadedRig::joint_count)
      .def("stylus", &LoadedRig::stylus);
}

}  // namespace palpate::python
