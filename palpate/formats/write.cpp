#include "palpate/formats/write.h"

#include <cmath>

#include "palpate/core/csv.h"
#include "palpate/core/json.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::formats {
namespace {

// All digits that give the same number again.
std::string digits(double value) { return fmt::format("{}", value); }
// A length that went from mm to m and back has its last digit from there.
std::string length(double value) { return fmt::format("{:.15g}", value); }

std::string_view kind_of(const Content& content) {
  constexpr std::array<std::string_view, 4> kKinds = {"poses", "points", "a lens", "a transform"};
  return kKinds[content.value.index()];
}

tl::unexpected<Error> no_place_for(const Content& content, std::string_view form, std::string_view holds) {
  return wrong_use("{} cannot be written as {}, which holds {}", kind_of(content), form, holds);
}

// A cell of CSV: on one line, quoted where it holds what separates cells.
std::string cell(const std::string& label) {
  const std::string text = one_line(label);
  if (text.find_first_of(",;\t\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("'") : std::string(1, c);
  return quoted + '"';
}

std::string poses_csv(const Poses& poses) {
  std::string text = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n";
  for (const auto& pose : poses.poses) {
    const auto& q = pose.rotation;
    const Vector3 mm = kMillimetresPerMetre * pose.translation;
    text += poses.has_time ? digits(pose.time_s) : std::string();
    for (const double value : {mm.x(), mm.y(), mm.z()}) text += ',' + length(value);
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) text += ',' + digits(value);
    text += '\n';
  }
  return text;
}

std::string points_csv(const Points& points) {
  std::string text = "x_mm,y_mm,z_mm,label\n";
  for (std::size_t i = 0; i < points.places.size(); ++i) {
    const Vector3 mm = kMillimetresPerMetre * points.places[i];
    text += fmt::format("{},{},{},{}\n", length(mm.x()), length(mm.y()), length(mm.z()),
                        points.labels.empty() ? std::to_string(i + 1) : cell(points.labels[i]));
  }
  return text;
}

Expected<std::string> csv(const Content& content) {
  if (const auto* poses = std::get_if<Poses>(&content.value)) return poses_csv(*poses);
  if (const auto* points = std::get_if<Points>(&content.value)) return points_csv(*points);
  return no_place_for(content, "csv", "poses or points");
}

Expected<std::string> tum(const Content& content) {
  const auto* poses = std::get_if<Poses>(&content.value);
  if (poses == nullptr || !poses->has_time) return no_place_for(content, "tum", "poses with times");
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  for (const auto& pose : poses->poses) {
    const auto& [t, q] = std::tie(pose.translation, pose.rotation);
    text += digits(pose.time_s);
    for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) text += ' ' + digits(value);
    text += '\n';
  }
  return text;
}

Expected<std::string> kitti(const Content& content) {
  const auto* poses = std::get_if<Poses>(&content.value);
  if (poses == nullptr) return no_place_for(content, "kitti", "poses");
  std::string text;
  for (const auto& pose : poses->poses) {
    const Matrix3 R = pose.rotation.toRotationMatrix();
    for (Eigen::Index r = 0; r < 3; ++r)
      text +=
          fmt::format("{} {} {} {}{}", R(r, 0), R(r, 1), R(r, 2), pose.translation[r], r < 2 ? " " : "\n");
  }
  return text;
}

Expected<std::string> euroc(const Content& content) {
  const auto* poses = std::get_if<Poses>(&content.value);
  if (poses == nullptr || !poses->has_time) return no_place_for(content, "euroc", "poses with times");
  std::string text =
      "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n";
  for (const auto& pose : poses->poses) {
    const auto& [t, q] = std::tie(pose.translation, pose.rotation);
    text += fmt::format(
        "{}", std::llround(1e9 * std::min(std::abs(pose.time_s), 9e9)) * (pose.time_s < 0 ? -1 : 1));
    for (const double value : {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()}) text += ',' + digits(value);
    text += '\n';
  }
  return text;
}

Expected<std::string> markups(const Content& content) {
  const auto* points = std::get_if<Points>(&content.value);
  if (points == nullptr) return no_place_for(content, "mrk-json", "points");
  Json list = Json::array();
  for (std::size_t i = 0; i < points->places.size(); ++i) {
    const Vector3 mm = kMillimetresPerMetre * points->places[i];
    list.push_back({{"id", std::to_string(i + 1)},
                    {"label", points->labels.empty() ? std::to_string(i + 1) : points->labels[i]},
                    {"position", {mm.x(), mm.y(), mm.z()}},
                    {"positionStatus", "defined"}});
  }
  const Json json = {
      {"@schema",
       "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
       "markups-schema-v1.0.3.json#"},
      {"markups",
       {{{"type", "Fiducial"},
         {"coordinateSystem", "LPS"},
         {"coordinateUnits", "mm"},
         {"controlPoints", list}}}}};
  return escaped_json(json.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n";
}

std::vector<double> coefficients(const Lens& lens) {
  return {lens.distortion.begin(),
          lens.distortion.begin() + static_cast<std::ptrdiff_t>(device::coefficient_count(lens.kind))};
}

Expected<std::string> lens_json(const Content& content) {
  const auto* lens = std::get_if<Lens>(&content.value);
  if (lens == nullptr) return no_place_for(content, "json", "a lens");
  Json json = {{"fx", lens->fx}, {"fy", lens->fy}, {"cx", lens->cx}, {"cy", lens->cy}};
  if (lens->kind != device::LensKind::brown) json["lens"] = device::lens_word(lens->kind);
  json["distortion"] = coefficients(*lens);
  if (lens->size) {
    json["width_px"] = (*lens->size)[0];
    json["height_px"] = (*lens->size)[1];
  }
  return json.dump(2) + "\n";
}

std::string list_of(const Lens& lens) { return fmt::format("{}", fmt::join(coefficients(lens), ", ")); }
std::string matrix_of(const Lens& lens) {
  return fmt::format("{}, 0.0, {}, 0.0, {}, {}, 0.0, 0.0, 1.0", lens.fx, lens.cx, lens.fy, lens.cy);
}

Expected<std::string> opencv(const Content& content) {
  const auto* lens = std::get_if<Lens>(&content.value);
  if (lens == nullptr) return no_place_for(content, "opencv", "a lens");
  std::string text = "%YAML:1.0\n---\n";
  if (lens->size)
    text += fmt::format("image_width: {}\nimage_height: {}\n", (*lens->size)[0], (*lens->size)[1]);
  text += fmt::format("camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {} ]\n",
                      matrix_of(*lens));
  // The mark by which OpenCV's calibration program says what the coefficients are.
  if (lens->kind == device::LensKind::fisheye) text += "fisheye_model: 1\n";
  text += fmt::format(
      "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: {}\n   dt: d\n   data: [ {} ]\n",
      coefficients(*lens).size(), list_of(*lens));
  return text;
}

const char* ros_word(device::LensKind kind) {
  return kind == device::LensKind::fisheye    ? "equidistant"
         : kind == device::LensKind::rational ? "rational_polynomial"
                                              : "plumb_bob";
}

Expected<std::string> camera_info(const Content& content) {
  const auto* lens = std::get_if<Lens>(&content.value);
  if (lens == nullptr || !lens->size)
    return no_place_for(content, "camera-info", "a lens and the picture's size");
  return fmt::format(
      "image_width: {}\nimage_height: {}\ncamera_name: camera\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: "
      "[{}]\n"
      "distortion_model: {}\ndistortion_coefficients:\n  rows: 1\n  cols: {}\n  data: [{}]\n"
      "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\n"
      "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [{}, 0.0, {}, 0.0, 0.0, {}, {}, 0.0, 0.0, 0.0, 1.0, "
      "0.0]\n",
      (*lens->size)[0], (*lens->size)[1], matrix_of(*lens), ros_word(lens->kind), coefficients(*lens).size(),
      list_of(*lens), lens->fx, lens->cx, lens->fy, lens->cy);
}

Expected<std::string> matrix_text(const Content& content) {
  const auto* transform = std::get_if<Transform>(&content.value);
  if (transform == nullptr) return no_place_for(content, "matrix", "a transform");
  Eigen::Matrix4d m = transform->matrix;
  m.topRightCorner<3, 1>() *= kMillimetresPerMetre;
  std::string text;
  for (Eigen::Index r = 0; r < 4; ++r)
    text += fmt::format("{} {} {} {}\n", m(r, 0), m(r, 1), m(r, 2), length(m(r, 3)));
  return text;
}

Expected<std::string> itk(const Content& content) {
  const auto* transform = std::get_if<Transform>(&content.value);
  if (transform == nullptr) return no_place_for(content, "tfm", "a transform");
  const auto& m = transform->matrix;
  std::string numbers;
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c) numbers += digits(m(r, c)) + ' ';
  const Vector3 mm = kMillimetresPerMetre * m.topRightCorner<3, 1>();
  return fmt::format(
      "#Insight Transform File V1.0\n#Transform 0\nTransform: AffineTransform_double_3_3\nParameters: {}{} "
      "{} {}\n"
      "FixedParameters: 0 0 0\n",
      numbers, length(mm.x()), length(mm.y()), length(mm.z()));
}

// A camera on what the tracker follows, as easy_handeye's files are read by its own programs.
Expected<std::string> easy_handeye(const Content& content) {
  const auto* transform = std::get_if<Transform>(&content.value);
  if (transform == nullptr) return no_place_for(content, "easy-handeye", "a transform");
  const Matrix3 R = transform->matrix.topLeftCorner<3, 3>();
  constexpr double kRotation = 1e-6;
  if ((R.transpose() * R - Matrix3::Identity()).norm() > kRotation || R.determinant() < 0.0)
    return wrong_use(
        "a transform that scales or shears cannot be written as easy-handeye; a rigid one is needed");
  const Quaternion q(R);
  const Vector3 t = transform->matrix.topRightCorner<3, 1>();
  return fmt::format(
      "parameters:\n  namespace: /palpate_eye_on_hand/\n  eye_on_hand: true\n  robot_base_frame: world\n  "
      "robot_effector_frame: camera_marker\n"
      "  tracking_base_frame: camera_optical\ntransformation:\n  x: {}\n  y: {}\n  z: {}\n  qx: {}\n  qy: "
      "{}\n  qz: {}\n"
      "  qw: {}\n",
      t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

struct Writer {
  WrittenForm form;
  Expected<std::string> (*text)(const Content&);
};

const std::vector<Writer>& writers() {
  static const std::vector<Writer> kWriters = {
      {{"csv", ".csv", "a table of poses or points of this program, mm"}, csv},
      {{"tum", ".tum", "t x y z qx qy qz qw, s and m"}, tum},
      {{"kitti", "", "3x4 matrices row by row, m, without times"}, kitti},
      {{"euroc", "", "a trajectory of EuRoC, ns and m"}, euroc},
      {{"mrk-json", ".mrk.json", "markups of 3D Slicer, LPS, mm"}, markups},
      {{"json", ".json", "a lens of this program, px"}, lens_json},
      {{"opencv", ".yml", "a lens of OpenCV (YAML), px"}, opencv},
      {{"camera-info", ".yaml", "a camera_info of ROS, px"}, camera_info},
      {{"matrix", ".txt", "a 4x4 matrix, mm"}, matrix_text},
      {{"tfm", ".tfm", "a transform of ITK as it is stored, LPS, mm"}, itk},
      {{"easy-handeye", "", "a calibration of easy_handeye (YAML), eye on hand, m"}, easy_handeye},
  };
  return kWriters;
}

}  // namespace

const std::vector<WrittenForm>& written_forms() {
  static const std::vector<WrittenForm> kForms = [] {
    std::vector<WrittenForm> forms;
    for (const auto& writer : writers()) forms.push_back(writer.form);
    return forms;
  }();
  return kForms;
}

Expected<WrittenForm> written_form(const std::filesystem::path& path, const std::string& wanted) {
  const std::string name = path.filename().string();
  const WrittenForm* found = nullptr;
  std::string names, endings;
  for (const auto& form : written_forms()) {
    names += (names.empty() ? "" : ", ") + form.name;
    if (!form.ending.empty() && (", " + endings + ",").find(", " + form.ending + ",") == std::string::npos)
      endings += (endings.empty() ? "" : ", ") + form.ending;
    const bool fits =
        wanted.empty() ? !form.ending.empty() && name.ends_with(form.ending) : form.name == wanted;
    if (fits && (found == nullptr || form.ending.size() > found->ending.size())) found = &form;
  }
  if (found != nullptr) return *found;
  if (!wanted.empty())
    return wrong_use("'{}' is no form that is written; there are {}", excerpt(wanted), names);
  return wrong_use("{}: its ending says no form; expected {}, or --to with one of {}", path.string(), endings,
                   names);
}

Expected<std::string> text_of(const Content& content, const WrittenForm& form) {
  for (const auto& writer : writers())
    if (writer.form.name == form.name) return writer.text(content);
  return wrong_use("'{}' is no form that is written", form.name);
}

}  // namespace palpate::formats
