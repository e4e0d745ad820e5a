// palpate._vision: what needs OpenCV, which takes longer to load than all else together; loaded when it is asked for.
#include "palpate/vision/camera_findings.h"

#include "python/bindings/conversions.h"

namespace palpate::python {
namespace {

// A view: its name, the corners on the board (K x 3, m) and in the image (K x 2, px).
using View = std::tuple<std::string, Doubles, Doubles>;

py::dict camera(const std::vector<View>& views, int width, int height, bool reject_outlier_views,
                std::vector<std::string> not_found, std::vector<std::string> warnings,
                const std::string& lens) {
  vision::BoardViews all;
  all.not_found = std::move(not_found);
  all.width = width, all.height = height;
  for (const auto& [name, board, image] : views) {
    vision::BoardView view{name, points_of(board), {}};
    for (py::ssize_t i = 0; i < image.shape(0); ++i) view.image.emplace_back(image.at(i, 0), image.at(i, 1));
    all.views.push_back(std::move(view));
  }
  const auto found = value_or_raise(unlocked([&] {
    return vision::find_camera(std::move(all),
                               {.reject_outlier_views = reject_outlier_views,
                                .lens = device::lens_kind(lens).value_or(device::LensKind::brown)},
                               std::move(warnings));
  }));
  const auto& model = found.estimate.value.model;
  auto fields = estimate_fields(found.estimate, found.json);
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K(0, 0) = model.fx, K(1, 1) = model.fy, K(0, 2) = model.cx, K(1, 2) = model.cy;
  fields["matrix"] = array_of(K);
  fields["lens"] = device::lens_word(model.kind);
  const auto coefficients = model.coefficients();
  fields["distortion"] = numbers_array({coefficients.begin(), coefficients.end()});
  const auto own = 4 + static_cast<Eigen::Index>(coefficients.size());
  fields["covariance"] = array_of(Eigen::MatrixXd(found.estimate.covariance.topLeftCorner(own, own)));
  fields["rms"] = found.estimate.value.rms_px;
  py::list poses;
  for (const auto& view : found.estimate.value.views) poses.append(pose_matrix(view.X_camera_board));
  fields["boards"] = poses;
  return fields;
}

py::tuple views_of(const vision::BoardViews& found) {
  py::list views;
  for (const auto& view : found.views) {
    Eigen::MatrixXd image(static_cast<Eigen::Index>(view.image.size()), 2);
    for (std::size_t i = 0; i < view.image.size(); ++i)
      image.row(static_cast<Eigen::Index>(i)) = view.image[i].transpose();
    views.append(py::make_tuple(view.name, rows_of(view.board), array_of(image)));
  }
  return py::make_tuple(views, found.width, found.height, found.not_found, found.doubt);
}

py::tuple read_corners(const std::string& file, int columns, int rows, double square) {
  return views_of(value_or_raise(unlocked([&] {
    return vision::read_board_corners(file, {columns, rows, square});
  })));
}

py::tuple find_corners(const std::string& pattern, int columns, int rows, double square,
                       std::optional<int> half_window) {
  return views_of(value_or_raise(unlocked([&] {
    return vision::read_board_images(pattern, {columns, rows, square}, half_window);
  })));
}

}  // namespace
}  // namespace palpate::python

PYBIND11_MODULE(_vision, module) {
  palpate::python::raise_failures();
  module.def("camera", &palpate::python::camera);
  module.def("read_corners", &palpate::python::read_corners);
  module.def("find_corners", &palpate::python::find_corners);
}
