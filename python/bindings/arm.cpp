#include "palpate/calibration/findings/arm.h"

#include "palpate/calibration/arm_prediction.h"
#include "palpate/device/arm_kinematics.h"
#include "python/bindings/conversions.h"
#include "python/bindings/module.h"

namespace palpate::python {
namespace {

namespace findings = calibration::findings;

calibration::ArmMethod arm_method(const std::string& name) {
  return name == "one-pass"      ? calibration::ArmMethod::one_pass
         : name == "alternating" ? calibration::ArmMethod::alternating
         : name == "eq7"         ? calibration::ArmMethod::eq7
                                 : calibration::ArmMethod::joint;
}

// Columns of samples as Python has them: what is absent is not in the dict.
class Columns {
 public:
  explicit Columns(const py::dict& columns) : columns_(columns) {}
  // One row's numbers; none where the column is absent.
  const double* row(const char* name, std::size_t i) const {
    if (!columns_.contains(name)) return nullptr;
    const auto array = py::cast<Doubles>(columns_[name]);
    return array.data() + i * static_cast<std::size_t>(array.size() / array.shape(0));
  }
  std::size_t rows() const {
    return static_cast<std::size_t>(py::cast<Doubles>(columns_["joints"]).shape(0));
  }
  py::ssize_t joints() const { return py::cast<Doubles>(columns_["joints"]).shape(1); }

 private:
  const py::dict& columns_;
};

std::optional<Vector3> place_at(const double* numbers) {
  if (numbers == nullptr) return std::nullopt;
  return Vector3(numbers[0], numbers[1], numbers[2]);
}

device::ArmSampleFile samples_of(const py::dict& dict, const char* name) {
  const Columns columns(dict);
  device::ArmSampleFile file{.source = name, .hash = {}, .observations = {}};
  for (std::size_t i = 0; i < columns.rows(); ++i) {
    device::ArmObservation sample;
    sample.joints = Eigen::Map<const Eigen::VectorXd>(columns.row("joints", i), columns.joints());
    sample.gimbal = place_at(columns.row("gimbal", i));
    if (const auto* time_s = columns.row("time", i)) sample.time_s = *time_s;
    if (const auto place = place_at(columns.row("marker_positions", i))) {
      const double* q = columns.row("marker_quaternions", i);
      sample.marker = {Quaternion(q[0], q[1], q[2], q[3]), *place};
    }
    if (const auto place = place_at(columns.row("tips", i))) sample.tip = {*place};
    if (const auto place = place_at(columns.row("targets", i))) sample.target = {*place};
    if (const auto* numbers = columns.row("covariances", i))
      sample.covariance = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers);
    if (const auto* systematic = columns.row("systematic", i)) sample.systematic = *systematic;
    file.observations.push_back(std::move(sample));
  }
  return file;
}

py::dict arm(const py::dict& samples, const std::string& model, const std::string& method, std::string free,
             const std::optional<Doubles>& tip, const std::optional<py::dict>& test, std::uint64_t seed) {
  findings::ArmTask task{.nominal = value_or_raise(device::read_arm_model(model)),
                         .samples = samples_of(samples, "samples"),
                         .method = arm_method(method),
                         .free = std::move(free),
                         .tip = point_of(tip),
                         .test = {},
                         .seed = seed};
  if (test) task.test = samples_of(*test, "test");
  for (const auto& sample : task.samples.observations)
    if (sample.joints.size() != task.nominal.joint_count())
      throw Failure{wrong_use("joints: has {} columns, the arm {} has {} joints", sample.joints.size(),
                              task.nominal.name, task.nominal.joint_count())
                        .value()};
  const auto found = value_or_raise(unlocked([&] { return findings::find_arm(std::move(task)); }));
  const auto& solution = found.estimate.value;
  auto fields = estimate_fields(found.estimate, found.json);
  fields["gains"] = list_of(solution.gain);
  fields["offsets"] = list_of(solution.offset);
  fields["base"] = pose_matrix(solution.X_world_base);
  fields["tip"] = solution.tip_known ? py::object(list_of(solution.tip_in_marker)) : py::none();
  fields["delay"] = solution.delay_s;
  fields["parameters"] = solution.parameters;
  fields["unseen_errors"] = rows_of(found.unseen);
  // What predicts the tip of these and other readings.
  fields["predictor"] = py::cast(found.estimate);
  return fields;
}

py::array predicted_tips(const Estimate<calibration::ArmSolution>& estimate, const Doubles& joints) {
  std::vector<Vector3> tips;
  for (py::ssize_t i = 0; i < joints.shape(0); ++i)
    tips.push_back(calibration::predict_tip(
                       estimate.value, Eigen::Map<const Eigen::VectorXd>(joints.data(i, 0), joints.shape(1)))
                       .m);
  return rows_of(tips);
}

py::array predicted_stds(const Estimate<calibration::ArmSolution>& estimate, const Doubles& joints) {
  std::vector<double> deviations;
  for (py::ssize_t i = 0; i < joints.shape(0); ++i)
    deviations.push_back(
        std::sqrt(calibration::predicted_covariance(
                      estimate, Eigen::Map<const Eigen::VectorXd>(joints.data(i, 0), joints.shape(1)))
                      .trace()));
  return numbers_array(deviations);
}

// Row by row, of the predicted tip.
py::array predicted_covariances(const Estimate<calibration::ArmSolution>& estimate, const Doubles& joints) {
  py::array_t<double> covariances({joints.shape(0), py::ssize_t{3}, py::ssize_t{3}});
  for (py::ssize_t i = 0; i < joints.shape(0); ++i)
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(covariances.mutable_data(i, 0, 0)) =
        calibration::predicted_covariance(
            estimate, Eigen::Map<const Eigen::VectorXd>(joints.data(i, 0), joints.shape(1)));
  return read_only(covariances);
}

}  // namespace

void add_arm(py::module_& module) {
  py::class_<Estimate<calibration::ArmSolution>>(module, "ArmPredictor")
      .def("tips", &predicted_tips)
      .def("stds", &predicted_stds)
      .def("covariances", &predicted_covariances);
  module.def("arm", &arm);
}

}  // namespace palpate::python
