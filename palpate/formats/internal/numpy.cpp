// Arrays of NumPy (.npy, versions 1 to 3): numpy.lib.format in NumPy's reference. A (3, 3) is a camera matrix, a (4, 4) a
// transform, (N, 4, 4) poses, (N, 3) points.
#include <bit>
#include <charconv>
#include <cstring>
#include <span>

#include "palpate/core/text.h"
#include "palpate/formats/internal/forms.h"
#include "palpate/formats/internal/lens_keys.h"
#include "palpate/formats/internal/pose_numbers.h"
#include "palpate/formats/internal/text_table.h"

namespace palpate::formats {
namespace {

constexpr std::string_view kMagic("\x93NUMPY", 6);
constexpr std::size_t kMostValues = 16'000'000;

struct Array {
  std::vector<std::size_t> shape;
  std::vector<double> values;  // the last index changes fastest
};

// What stands behind 'key': in the header's dictionary.
std::string_view behind(std::string_view header, std::string_view key) {
  const auto at = header.find(key);
  return at == std::string_view::npos ? std::string_view() : trimmed(header.substr(at + key.size()));
}

std::optional<std::vector<std::size_t>> shape_in(std::string_view header) {
  auto text = behind(header, "'shape':");
  if (!text.starts_with('(')) return std::nullopt;
  const auto end = text.find(')');
  if (end == std::string_view::npos) return std::nullopt;
  std::vector<std::size_t> shape;
  for (const auto cell : cells_of(text.substr(1, end - 1), ',', 8)) {
    if (cell.empty()) continue;
    std::size_t size = 0;
    const auto [rest, code] = std::from_chars(cell.data(), cell.data() + cell.size(), size);
    if (code != std::errc() || rest != cell.data() + cell.size()) return std::nullopt;
    shape.push_back(size);
  }
  return shape;
}

template <typename Number>
void take_values(std::string_view data, std::vector<double>& values) {
  static_assert(std::endian::native == std::endian::little);
  for (std::size_t i = 0; i < values.size(); ++i) {
    Number value;
    std::memcpy(&value, data.data() + i * sizeof(Number), sizeof(Number));
    values[i] = static_cast<double>(value);
  }
}

// From columns first to rows first.
void turn_order(Array& array) {
  const std::vector<double> given = array.values;
  std::vector<std::size_t> index(array.shape.size(), 0);
  for (double& value : array.values) {
    std::size_t at = 0;
    for (std::size_t k = array.shape.size(); k-- > 0;) at = at * array.shape[k] + index[k];
    value = given[at];
    for (std::size_t k = array.shape.size(); k-- > 0;) {
      if (++index[k] < array.shape[k]) break;
      index[k] = 0;
    }
  }
}

Expected<Array> array_in(const Source& source) {
  const auto content = source.content;
  const auto bad = [&](std::string_view why) {
    return wrong_use("{}: is an array of NumPy (.npy) {}", source.name, why);
  };
  if (content.size() < 12) return bad("that was cut off");
  const bool old = content[6] == 1;
  std::size_t length = 0;
  for (std::size_t i = 0; i < (old ? 2u : 4u); ++i)
    length |= static_cast<std::size_t>(static_cast<unsigned char>(content[8 + i])) << (8 * i);
  const std::size_t begin = old ? 10 : 12;
  if (length > 65'536 || content.size() < begin + length) return bad("that was cut off");
  const auto header = content.substr(begin, length);
  const auto type = behind(header, "'descr':");
  Array array;
  const auto shape = shape_in(header);
  if (!shape || shape->empty() || shape->size() > 3)
    return bad("of a shape that is not read; (3, 3), (4, 4), (N, 4, 4) or (N, 3) are");
  array.shape = *shape;
  std::size_t count = 1;
  for (const std::size_t size : array.shape) {
    if (size == 0 || size > kMostValues || count > kMostValues / size)
      return bad("that is empty or too large");
    count *= size;
  }
  const bool doubles = type.starts_with("'<f8'"), floats = type.starts_with("'<f4'");
  if (!doubles && !floats) return bad("whose values are no floating-point numbers; save it as float64");
  const auto data = content.substr(begin + length);
  if (data.size() != count * (doubles ? 8 : 4))
    return bad("that was cut off, or holds more than its header says");
  array.values.resize(count);
  if (doubles)
    take_values<double>(data, array.values);
  else
    take_values<float>(data, array.values);
  if (array.shape.size() > 1 && behind(header, "'fortran_order':").starts_with("True")) turn_order(array);
  for (const double value : array.values)
    if (!std::isfinite(value)) return bad("that holds nan or infinity");
  return array;
}

Expected<double> unit_of_array(const Source& source) {
  if (source.options.metres_per_unit > 0) return source.options.metres_per_unit;
  return wrong_use(
      "{}: is an array of NumPy (.npy), which says no unit; a unit is needed: palpate convert --unit mm, or "
      "m",
      source.name);
}

}  // namespace

bool is_numpy(std::string_view content) { return content.starts_with(kMagic); }

Expected<Content> read_numpy(const Source& source) {
  const auto array = array_in(source);
  if (!array) return tl::unexpected(array.error());
  const auto& v = array->values;
  const auto& shape = array->shape;
  const std::string form = "an array of NumPy (.npy)";
  if (shape == std::vector<std::size_t>{3, 3}) {
    const NumbersAt numbers_at = [&](const std::string& key) {
      return key == "camera_matrix" ? std::optional(v) : std::nullopt;
    };
    const auto lens = lens_of(numbers_at, "", source.name);
    if (!lens) return tl::unexpected(lens.error());
    return Content{form, "a camera matrix, px, without distortion", *lens};
  }
  const bool poses_or_places = shape == std::vector<std::size_t>{4, 4} ||
                               (shape.size() == 3 && shape[1] == 4 && shape[2] == 4) ||
                               (shape.size() == 2 && shape[1] == 3);
  if (!poses_or_places)
    return wrong_use(
        "{}: is {} of a shape that is not read; (3, 3), (4, 4), (N, 4, 4) or (N, 3) are expected",
        source.name, form);
  const auto scale = unit_of_array(source);
  if (!scale) return tl::unexpected(scale.error());
  const std::string unit = *scale == 1.0 ? "m" : "mm";
  if (shape == std::vector<std::size_t>{4, 4}) {
    Transform transform;
    transform.matrix = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(v.data());
    transform.matrix.topRightCorner<3, 1>() *= *scale;
    const auto sound = transform_of(transform.matrix, source.name);
    if (!sound) return tl::unexpected(sound.error());
    return Content{form, unit, *sound};
  }
  if (shape.size() == 3 && shape[1] == 4 && shape[2] == 4) {
    Poses poses;
    for (std::size_t i = 0; i < shape[0]; ++i) {
      auto pose = device::pose_from_matrix(std::span(v).subspan(16 * i, 16), *scale,
                                           fmt::format("{}: matrix {}", source.name, i));
      if (!pose) return tl::unexpected(pose.error());
      pose->time_s = static_cast<double>(i);
      poses.poses.push_back(*pose);
    }
    return Content{form, unit, poses};
  }
  Points points;
  for (std::size_t i = 0; i < shape[0]; ++i) {
    const auto at = place_of(*scale * Vector3(v[3 * i], v[3 * i + 1], v[3 * i + 2]),
                             fmt::format("{}: row {}", source.name, i));
    if (!at) return tl::unexpected(at.error());
    points.places.push_back(*at);
  }
  return Content{form, unit, points};
}

}  // namespace palpate::formats
