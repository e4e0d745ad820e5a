// Transforms of ITK as text (.tfm, .txt), which 3D Slicer, ANTs and elastix write.
//
// The file holds the resampling transform: it takes points of the fixed image, where the result is drawn, to points of the moving
// one, in LPS and mm. Slicer shows the inverse, in RAS. Parameters: ITK Software Guide, 4th edition, section 3.9.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/text.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/internal/pose_numbers.h"
#include "palpate/formats/internal/text_table.h"
#include "palpate/math/so3.h"

namespace palpate::formats {
namespace {

using Numbers = std::vector<double>;

struct Entry {
  std::string kind;        // "AffineTransform"
  std::string numbers_of;  // "double_3_3"
  Numbers parameters, fixed;
};

Expected<Numbers> numbers_of(std::string_view text, const std::string& where) {
  Numbers numbers;
  for (const auto cell : cells_of(text, ' ', 1000)) {
    const auto number = number_of(cell);
    if (!number) return wrong_use("{}: '{}' is no finite number", where, excerpt(cell, 24));
    numbers.push_back(*number);
  }
  return numbers;
}

Expected<std::vector<Entry>> entries_of(const Source& source) {
  std::vector<Entry> entries;
  std::string_view content = source.content;
  int number = 0;
  while (const auto raw = next_line(content)) {
    ++number;
    const auto line = trimmed(*raw);
    const auto colon = line.find(':');
    if (line.empty() || line.front() == '#' || colon == std::string_view::npos) continue;
    const auto key = trimmed(line.substr(0, colon)), value = trimmed(line.substr(colon + 1));
    if (key == "Transform") {
      const auto end = value.find('_');
      entries.push_back({std::string(value.substr(0, end)),
                         std::string(end == std::string_view::npos ? "" : value.substr(end + 1)),
                         {},
                         {}});
    } else if ((key == "Parameters" || key == "FixedParameters") && !entries.empty()) {
      auto numbers = numbers_of(value, fmt::format("{}:{}", source.name, number));
      if (!numbers) return tl::unexpected(numbers.error());
      (key == "Parameters" ? entries.back().parameters : entries.back().fixed) = std::move(*numbers);
    }
  }
  return entries;
}

Matrix3 matrix_of(const Numbers& p) {
  Matrix3 A;
  for (std::size_t i = 0; i < 9; ++i)
    A(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) = p[i];
  return A;
}

Vector3 vector_at(const Numbers& p, std::size_t at) { return {p[at], p[at + 1], p[at + 2]}; }

Matrix3 turn(const Vector3& axis, double angle) { return Eigen::AngleAxisd(angle, axis).toRotationMatrix(); }

// The vector part of a unit quaternion; its scalar part is not negative.
std::optional<Matrix3> rotation_of_versor(const Vector3& v) {
  const double rest = 1.0 - v.squaredNorm();
  if (rest < -1e-9) return std::nullopt;
  return Quaternion(std::sqrt(std::max(0.0, rest)), v.x(), v.y(), v.z()).normalized().toRotationMatrix();
}

// y = A (x - c) + t + c
struct Mapping {
  Matrix3 A = Matrix3::Identity();
  Vector3 t = Vector3::Zero();
};

std::optional<Mapping> mapping_of(const Entry& entry) {
  const auto& p = entry.parameters;
  const auto has = [&](std::size_t count) { return p.size() == count; };
  if (entry.kind == "IdentityTransform") return Mapping{};
  if (entry.kind == "TranslationTransform" && has(3)) return Mapping{Matrix3::Identity(), vector_at(p, 0)};
  if ((entry.kind == "AffineTransform" || entry.kind == "MatrixOffsetTransformBase" ||
       entry.kind == "Rigid3DTransform" || entry.kind == "ScaleSkewVersor3DTransform") &&
      has(12))
    return Mapping{matrix_of(p), vector_at(p, 9)};
  if (entry.kind == "Euler3DTransform" && has(6)) {
    const Matrix3 X = turn(Vector3::UnitX(), p[0]), Y = turn(Vector3::UnitY(), p[1]),
                  Z = turn(Vector3::UnitZ(), p[2]);
    const bool zyx = entry.fixed.size() == 4 && entry.fixed[3] != 0.0;
    return Mapping{zyx ? Matrix3(Z * Y * X) : Matrix3(Z * X * Y), vector_at(p, 3)};
  }
  if ((entry.kind == "VersorRigid3DTransform" && has(6)) ||
      (entry.kind == "Similarity3DTransform" && has(7))) {
    const auto rotation = rotation_of_versor(vector_at(p, 0));
    if (!rotation) return std::nullopt;
    const double scale = has(7) ? p[6] : 1.0;
    return Mapping{scale * *rotation, vector_at(p, 3)};
  }
  if (entry.kind == "QuaternionRigidTransform" && has(7)) {
    const Quaternion q(p[3], p[0], p[1], p[2]);
    if (!(std::abs(q.norm() - 1.0) < 1e-3)) return std::nullopt;
    return Mapping{q.normalized().toRotationMatrix(), vector_at(p, 4)};
  }
  return std::nullopt;
}

}  // namespace

bool is_itk_transform(std::string_view content) { return content.starts_with("#Insight Transform File"); }

Expected<Content> read_itk_transform(const Source& source) {
  if (source.content.size() > kMostBytesOfAFew)
    return wrong_use("{}: is a transform of ITK that is no matrix, for it is too large for one", source.name);
  const std::string form = "a transform of ITK (.tfm)";
  // A grid of displacements is named before its thousands of numbers are read.
  for (const std::string_view grid : {"BSpline", "DisplacementField", "ThinPlate", "Spline"})
    if (source.content.substr(0, 1000).find(grid) != std::string_view::npos)
      return wrong_use("{}: is {} of kind {}, which bends space; a rigid or affine one is expected",
                       source.name, form, grid);
  const auto entries = entries_of(source);
  if (!entries) return tl::unexpected(entries.error());
  if (entries->size() != 1)
    return wrong_use("{}: is {} that holds {}; a single one is expected, harden it before", source.name, form,
                     counted(entries->size(), "transform"));
  const Entry& entry = entries->front();
  if (!entry.numbers_of.empty() && !entry.numbers_of.ends_with("3_3"))
    return wrong_use("{}: is {} for {}; one of three dimensions is expected", source.name, form,
                     excerpt(entry.numbers_of));
  const auto mapping = mapping_of(entry);
  if (!mapping)
    return wrong_use(
        "{}: is {}, of kind {} with {}, which is not read; a rigid or affine one is expected, harden it into "
        "a linear one",
        source.name, form, excerpt(entry.kind), counted(entry.parameters.size(), "parameter"));
  const Vector3 centre = entry.fixed.size() >= 3 ? vector_at(entry.fixed, 0) : Vector3::Zero();
  Transform transform;
  transform.matrix.topLeftCorner<3, 3>() = mapping->A;
  transform.matrix.topRightCorner<3, 1>() = 1e-3 * (mapping->t + centre - mapping->A * centre);
  const auto sound = transform_of(transform.matrix, source.name);
  if (!sound) return tl::unexpected(sound.error());
  return Content{form, "as ITK stores it: from the fixed to the moving image, LPS, mm", *sound};
}

}  // namespace palpate::formats
