#include "palpate/formats/internal/lens_keys.h"

#include <algorithm>
#include <cmath>

#include "palpate/core/text.h"

namespace palpate::formats {
namespace {

constexpr std::array kMatrixKeys = {"camera_matrix",
                                    "Camera_Matrix",
                                    "cameraMatrix",
                                    "CameraMatrix",
                                    "intrinsic_matrix",
                                    "camera_intrinsics",
                                    "intrinsics",
                                    "K",
                                    "M1",
                                    "mtx",
                                    "cameraMatrix1"};
constexpr std::array kDistortionKeys = {"distortion_coefficients",
                                        "Distortion_Coefficients",
                                        "distortionCoefficients",
                                        "DistortionCoefficients",
                                        "distortion",
                                        "dist_coeffs",
                                        "dist_coeff",
                                        "dist_coefs",
                                        "dist_coef",
                                        "distCoeff",
                                        "distortion_coefficient",
                                        "distortion_coeff",
                                        "distortion_coeffs",
                                        "distCoeffs",
                                        "distCoeffs1",
                                        "dist",
                                        "D",
                                        "D1"};
constexpr std::array kWidthKeys = {"image_width", "image_Width", "imageWidth", "width", "img_width"};
constexpr std::array kHeightKeys = {"image_height", "image_Height", "imageHeight", "height", "img_height"};
constexpr std::array kSizeKeys = {"image_size", "imageSize", "img_size", "resolution", "size"};
constexpr double kLargest = 1e6;   // px, of a focal length or a size
constexpr double kNoMore = 1e-12;  // a coefficient that does nothing

template <std::size_t N>
std::optional<std::vector<double>> first_of(const NumbersAt& numbers_at,
                                            const std::array<const char*, N>& keys) {
  for (const char* key : keys)
    if (auto numbers = numbers_at(key)) return numbers;
  return std::nullopt;
}

std::optional<std::array<int, 2>> size_of(const NumbersAt& numbers_at) {
  auto width = first_of(numbers_at, kWidthKeys), height = first_of(numbers_at, kHeightKeys);
  if (const auto both = first_of(numbers_at, kSizeKeys); !width && both && both->size() == 2) {
    width = std::vector{(*both)[0]};
    height = std::vector{(*both)[1]};
  }
  if (!width || !height || width->size() != 1 || height->size() != 1) return std::nullopt;
  const double w = width->front(), h = height->front();
  if (!(w >= 1 && w <= kLargest && h >= 1 && h <= kLargest)) return std::nullopt;
  return std::array{static_cast<int>(w), static_cast<int>(h)};
}

bool is_fisheye(const std::string& model) {
  constexpr std::array kNames = {"equidistant", "fisheye", "kannala_brandt", "kannala_brandt4",
                                 "KannalaBrandt"};
  return std::find(kNames.begin(), kNames.end(), model) != kNames.end();
}

// What programs call the kinds of lens that are read; nothing: they say none.
bool is_known_model(const std::string& model) {
  constexpr std::array kKnown = {"",       "plumb_bob", "rational_polynomial", "none",
                                 "brown",  "Brown",     "brown_conrady",       "radtan",
                                 "opencv", "pinhole",   "radial-tangential"};
  return is_fisheye(model) || std::find(kKnown.begin(), kKnown.end(), model) != kKnown.end();
}

Expected<void> take_distortion(std::vector<double> numbers, const std::string& model,
                               const std::string& source, Lens& lens) {
  if (!is_known_model(model))
    return wrong_use(
        "{}: its lens is '{}'; plumb_bob (k1 k2 p1 p2 k3), rational_polynomial (with k4 k5 k6) or "
        "equidistant (k1 k2 k3 "
        "k4) is expected",
        source, excerpt(model, 40));
  if (std::any_of(numbers.begin(), numbers.end(), [](double k) { return !(std::abs(k) < kLargest); }))
    return wrong_use("{}: a distortion coefficient is no number of a lens; repair it", source);
  if (is_fisheye(model)) {
    lens.kind = device::LensKind::fisheye;
    while (numbers.size() > 4 && std::abs(numbers.back()) < kNoMore) numbers.pop_back();
    if (numbers.size() != 4)
      return wrong_use("{}: has {} of a fisheye lens; 4 are expected: k1 k2 k3 k4", source,
                       counted(numbers.size(), "distortion coefficient"));
  }
  while (numbers.size() > 5 && std::abs(numbers.back()) < kNoMore) numbers.pop_back();
  if (numbers.size() > device::kMostCoefficients)
    return wrong_use(
        "{}: has {} distortion coefficients, of a thin prism or a tilted sensor; at most the eight of a "
        "rational lens "
        "are expected, k1 k2 p1 p2 k3 k4 k5 k6: calibrate without the others",
        source, numbers.size());
  if (numbers.size() > 5) lens.kind = device::LensKind::rational;
  if (!numbers.empty() && numbers.size() < 4)
    return wrong_use("{}: has {}; 4, 5 or 8 are expected: k1 k2 p1 p2 k3 k4 k5 k6", source,
                     counted(numbers.size(), "distortion coefficient"));
  std::copy(numbers.begin(), numbers.end(), lens.distortion.begin());
  return {};
}

}  // namespace

std::string told_of(const Lens& lens) {
  const auto& d = lens.distortion;
  if (std::all_of(d.begin(), d.end(), [](double k) { return k == 0.0; })) return "px, without distortion";
  return std::string("px, ") + device::coefficient_names(lens.kind);
}

Expected<NumbersAt> one_camera(const NumbersAt& numbers_at, const std::string& wanted,
                               const std::string& source) {
  struct Pair {
    const char *matrix, *distortion;
  };
  constexpr std::array kPairs = {Pair{"M", "D"}, Pair{"cameraMatrix", "distCoeffs"}, Pair{"K", "D"}};
  for (const auto& [matrix, distortion] : kPairs) {
    const std::string m = matrix;
    if (!numbers_at(m + "1") || !numbers_at(m + "2")) continue;
    if (wanted != m + "1" && wanted != m + "2")
      return wrong_use("{}: holds two cameras, {}1 and {}2; name one with --tool", source, m, m);
    const char which = wanted.back();
    return NumbersAt(
        [numbers_at, own = m + which, bend = std::string(distortion) + which](const std::string& key) {
          if (key == "camera_matrix") return numbers_at(own);
          if (key == "distortion_coefficients") return numbers_at(bend);
          const bool of_a_camera = key.ends_with('1') || key.ends_with('2');
          return of_a_camera ? std::optional<std::vector<double>>() : numbers_at(key);
        });
  }
  if (wanted.empty()) return numbers_at;
  return wrong_use("{}: holds one camera; remove --tool {}", source, excerpt(wanted, 40));
}

bool has_lens(const NumbersAt& numbers_at) { return first_of(numbers_at, kMatrixKeys).has_value(); }

Expected<Lens> lens_of(const NumbersAt& numbers_at, const std::string& model, const std::string& source) {
  const auto K = first_of(numbers_at, kMatrixKeys);
  if (!K || (K->size() != 9 && K->size() != 4))
    return wrong_use("{}: no camera matrix of 3x3 numbers", source);
  Lens lens;
  if (K->size() == 4) {
    lens.fx = (*K)[0], lens.fy = (*K)[1], lens.cx = (*K)[2], lens.cy = (*K)[3];
  } else {
    const auto& k = *K;
    lens.fx = k[0], lens.fy = k[4], lens.cx = k[2], lens.cy = k[5];
    if (std::abs(k[3]) > 1e-9 || std::abs(k[6]) > 1e-9 || std::abs(k[7]) > 1e-9 ||
        std::abs(k[8] - 1.0) > 1e-9)
      return wrong_use("{}: its camera matrix is none: 0 0 1 are expected in the last row, 0 below fx",
                       source);
    if (std::abs(k[1]) > 1e-6 * k[0])
      return wrong_use("{}: its camera matrix has a skew of {:g} px; a camera without is expected", source,
                       k[1]);
  }
  const auto is_length = [](double f) { return f > 0.0 && f < kLargest; };
  if (!is_length(lens.fx) || !is_length(lens.fy) || !(std::abs(lens.cx) < kLargest) ||
      !(std::abs(lens.cy) < kLargest))
    return wrong_use("{}: focal lengths are {:g} and {:g} px; numbers above 0 are expected", source, lens.fx,
                     lens.fy);
  lens.size = size_of(numbers_at);
  if (const auto distortion = first_of(numbers_at, kDistortionKeys))
    if (auto taken = take_distortion(*distortion, model, source, lens); !taken)
      return tl::unexpected(taken.error());
  return lens;
}

}  // namespace palpate::formats
