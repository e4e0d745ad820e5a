#include "palpate/vision/landmark_detector.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "palpate/core/statistics.h"
#include "palpate/math/levenberg_marquardt.h"

namespace palpate::vision {
namespace {

// The ring reaches three times as far as the disc; what is fitted ends inside it.
constexpr double kWindow = 2.2;  // radii of the disc
// px: neighbouring residuals hang together (levels, a ring's outer edge, shadows), which the fit's covariance
// ignores.
constexpr double kModel = 0.02;
// The window follows the fitted place until it moves by less than this, px: a pixel or two of its rim change.
constexpr double kWindowShift = 0.02;
constexpr int kWindowRounds = 8;
// px: what the edges of a picture may be softened by beside the pixel, as a box of this width. Colours filled in from a Bayer pattern
// are averages of neighbours, of a variance of 0.4 px^2: a box of 2.2 px.
constexpr std::array kSoftness{0.0, 1.2, 2.2};
// As sharp as the model says: rms of the fits over the contrast, median of a picture.
constexpr double kSharp = 0.06;

double light_of(double level, device::Encoding encoding) {
  switch (encoding) {
    case device::Encoding::srgb:  // IEC 61966-2-1
      return level <= 0.04045 ? level / 12.92 : std::pow((level + 0.055) / 1.055, 2.4);
    case device::Encoding::linear:
      return level;
    case device::Encoding::root:
      break;
  }
  return level * level;
}

constexpr double kNoPlace = 1.0;  // px; a sighting that may be off so far is none

struct Prediction {
  device::Pixel centre;
  Eigen::Matrix2d radii;  // maps the unit circle onto the disc's outline, px
  double short_axis;      // px
};

std::optional<Prediction> predict(const device::CameraModel& camera, const Pose<CameraOptical, World>& X,
                                  const rig::Landmark& mark) {
  const Vector3 c = (X * mark.place).m, n = X.rotation * mark.normal.normalized();
  if (c.z() < 0.05 || n.dot(c) > -0.1 * c.norm())
    return std::nullopt;  // behind, or seen at less than 6 degrees
  const Vector3 a = n.unitOrthogonal(), b = n.cross(a);
  const double r = 0.5 * mark.diameter;
  Prediction p;
  p.centre = camera.project(c);
  // A ray far outside may fold back into the picture; where the lens can be undone it comes back to itself.
  const auto undone = camera.undistort_pixel(p.centre);
  if (!undone || (*undone - camera.project_undistorted(c)).norm() > 0.01) return std::nullopt;
  p.radii.col(0) = 0.5 * (camera.project(c + r * a) - camera.project(c - r * a));
  p.radii.col(1) = 0.5 * (camera.project(c + r * b) - camera.project(c - r * b));
  const Eigen::Matrix2d S = p.radii * p.radii.transpose();
  const double half = 0.5 * S.trace(), root = std::sqrt(std::max(0.0, half * half - S.determinant()));
  p.short_axis = std::sqrt(std::max(0.0, half - root));
  const double reach = kWindow * std::sqrt(half + root) + 2.0;
  if (p.centre.x() < reach || p.centre.y() < reach || p.centre.x() > camera.width - 1 - reach ||
      p.centre.y() > camera.height - 1 - reach) {
    return std::nullopt;
  }
  return p;
}

// The neighbourhood of a prediction in linear light, cut to the image.
class Patch {
 public:
  Patch(const device::CameraImage& image, const std::array<double, 256>& linear, const device::Pixel& middle,
        double half_u, double half_v) {
    left_ = std::max(0, static_cast<int>(std::floor(middle.x() - half_u)));
    above_ = std::max(0, static_cast<int>(std::floor(middle.y() - half_v)));
    width_ = std::min(image.width - 1, static_cast<int>(std::ceil(middle.x() + half_u))) - left_ + 1;
    height_ = std::min(image.height - 1, static_cast<int>(std::ceil(middle.y() + half_v))) - above_ + 1;
    values_.reserve(static_cast<std::size_t>(std::max(0, width_) * std::max(0, height_)));
    for (int v = above_; v < above_ + height_; ++v) {
      const std::uint8_t* at =
          image.rgb.data() + 3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) +
                                  static_cast<std::size_t>(left_));
      for (int u = 0; u < width_; ++u, at += 3) {
        values_.push_back((linear[at[0]] + linear[at[1]] + linear[at[2]]) / 3.0);
      }
    }
  }
  double at(int u, int v) const {
    return values_[static_cast<std::size_t>(v - above_) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(u - left_)];
  }
  bool holds(double left, double above, double right, double below) const {
    return left >= left_ && above >= above_ && right <= left_ + width_ - 1 && below <= above_ + height_ - 1;
  }

 private:
  int left_, above_, width_, height_;
  std::vector<double> values_;
};

// Share of a pixel covered by the disc, and its derivative with respect to the disc's centre. `q` is the
// pixel minus the centre in radii (unit circle); the edge is a straight line within the pixel, softened by
// its width, and by a box of `softness` px more, whose variance is added to that of the pixel's wider side.
struct Cover {
  double value;
  Eigen::Vector2d slope;
};
Cover cover(const Eigen::Matrix2d& to_circle, const Eigen::Vector2d& offset, double softness) {
  const Eigen::Vector2d q = to_circle * offset;
  const double length = q.norm();
  if (length < 1e-9) return {1.0, Eigen::Vector2d::Zero()};
  const Eigen::Vector2d gradient = to_circle.transpose() * q / length;  // of the length, per px
  const double steep = gradient.norm();
  const double distance = (1.0 - length) / steep;  // px inside the outline, along its normal
  // A unit pixel's shadow along that normal: a trapezium, from the sum of two boxes.
  const double across = std::abs(gradient.x()) / steep, down = std::abs(gradient.y()) / steep;
  const double t = std::min(across, down);
  const double s = softness > 0.0 ? std::hypot(std::max(across, down), softness) : std::max(across, down);
  const double wide = 0.5 * (s + t), narrow = 0.5 * std::abs(s - t);
  const double x = std::abs(distance);
  double tail = 0.0, density = 0.0;  // area beyond x, and its rate
  if (x < narrow) {
    density = 1.0 / (wide + narrow);
    tail = 0.5 - x * density;
  } else if (x < wide) {
    const double peak = 1.0 / (wide + narrow), left = wide - x;
    density = peak * left / std::max(wide - narrow, 1e-12);
    tail = 0.5 * density * left;
  }
  return {distance > 0 ? 1.0 - tail : tail, density / steep * gradient};
}

// Where, within the search range, a disc of the predicted size stands out most from what surrounds it.
std::optional<device::Pixel> coarse(const Patch& light, const Prediction& p, double search) {
  const Eigen::Matrix2d to_circle = p.radii.inverse();
  const double reach_u = kWindow * p.radii.row(0).norm(), reach_v = kWindow * p.radii.row(1).norm();
  // The disc sampled once: bright and dark places relative to its centre.
  std::array<std::array<int, 2>, 400> places{};
  std::array<double, 400> weights{};
  std::size_t count = 0;
  double inside = 0.0, outside = 0.0;
  for (int v = -static_cast<int>(reach_v); v <= static_cast<int>(reach_v); ++v) {
    for (int u = -static_cast<int>(reach_u); u <= static_cast<int>(reach_u); ++u) {
      const double q = (to_circle * Eigen::Vector2d(u, v)).norm();
      if (q > kWindow || (q > 1.0 && q < 1.4) || count == places.size()) continue;
      places[count] = {u, v};
      weights[count++] = q <= 1.0 ? 1.0 : -1.0;
      (q <= 1.0 ? inside : outside) += 1.0;
    }
  }
  if (inside < 1.0 || outside < 4.0) return std::nullopt;
  for (std::size_t i = 0; i < count; ++i) weights[i] /= weights[i] > 0 ? inside : outside;
  const int u0 = static_cast<int>(std::lround(p.centre.x())),
            v0 = static_cast<int>(std::lround(p.centre.y()));
  const int range = static_cast<int>(std::ceil(search));
  double best = 0.0;
  std::optional<device::Pixel> place;
  for (int dv = -range; dv <= range; ++dv) {
    for (int du = -range; du <= range; ++du) {
      if (du * du + dv * dv > search * search + 1.0) continue;
      const int u = u0 + du, v = v0 + dv;
      if (!light.holds(u - reach_u, v - reach_v, u + reach_u, v + reach_v)) continue;
      // The middle must be brighter than the best contrast so far: most places are passed over after one
      // look.
      if (light.at(u, v) < best) continue;
      double sum = 0.0;
      for (std::size_t i = 0; i < count; ++i)
        sum += weights[i] * light.at(u + places[i][0], v + places[i][1]);
      if (sum > best) {
        best = sum;
        place = device::Pixel(u, v);
      }
    }
  }
  return place;
}

// A disc in its dark ring: where it is, and how bright both are, in linear light.
struct Disc {
  device::Pixel centre;
  double bright = 0.0, ground = 0.0;

  double contrast() const { return bright - ground; }
  Disc moved(const Eigen::Vector4d& step) const {
    return {centre + step.head<2>(), bright + step[2], ground + step[3]};
  }
};

// The pixels about a place that a disc is fitted to. They stay the same while it is, so that costs compare.
class DiscWindow {
 public:
  DiscWindow(const Patch& light, const Prediction& p, const device::Pixel& middle, double softness)
      : light_(light), to_circle_(p.radii.inverse()), middle_(middle), softness_(softness) {
    const double reach_u = kWindow * p.radii.row(0).norm(), reach_v = kWindow * p.radii.row(1).norm();
    left_ = static_cast<int>(std::ceil(middle.x() - reach_u));
    right_ = static_cast<int>(std::floor(middle.x() + reach_u));
    above_ = static_cast<int>(std::ceil(middle.y() - reach_v));
    below_ = static_cast<int>(std::floor(middle.y() + reach_v));
    fits_ = light.holds(left_, above_, right_, below_);
    if (!fits_) return;
    each([&](int, int) { ++pixels_; });
  }
  bool fits() const { return fits_ && pixels_ >= 8; }
  int pixels() const { return pixels_; }
  const device::Pixel& middle() const { return middle_; }

  double evaluate(const Disc& disc, NormalEquations<4>* equations) const {
    double squares = 0.0;
    each([&](int u, int v) {
      const Cover c = cover(to_circle_, device::Pixel(u, v) - disc.centre, softness_);
      const double r = disc.ground + disc.contrast() * c.value - light_.at(u, v);
      squares += r * r;
      if (!equations) return;
      const Eigen::Vector4d J(disc.contrast() * c.slope.x(), disc.contrast() * c.slope.y(), c.value,
                              1.0 - c.value);
      equations->JtJ += J * J.transpose();
      equations->Jtr += J * r;
    });
    return squares;
  }

 private:
  template <typename F>
  void each(const F& f) const {
    for (int v = above_; v <= below_; ++v)
      for (int u = left_; u <= right_; ++u)
        if ((to_circle_ * (device::Pixel(u, v) - middle_)).squaredNorm() <= kWindow * kWindow) f(u, v);
  }

  const Patch& light_;
  Eigen::Matrix2d to_circle_;
  device::Pixel middle_;
  double softness_;
  int left_ = 0, right_ = 0, above_ = 0, below_ = 0, pixels_ = 0;
  bool fits_ = false;
};

// However badly the pixels fit.
std::optional<LandmarkSighting> fit(const Patch& light, const Prediction& p, const device::Pixel& start,
                                    double softness, const LandmarkDetectorSettings& settings) {
  Disc disc{start};
  {
    const DiscWindow window(light, p, start, softness);
    if (!window.fits()) return std::nullopt;
    // Without contrast the place tells nothing: a first step finds the two brightnesses alone.
    NormalEquations<4> levels;
    window.evaluate(disc, &levels);
    disc = disc.moved(levels.solve(0.0).step);
    if (!(disc.contrast() >= 0.5 * settings.least_contrast)) return std::nullopt;
  }
  LandmarkSighting result;
  bool settled = false;
  // The window follows the disc, until it need not.
  for (int round = 0; round < kWindowRounds && !settled; ++round) {
    const DiscWindow window(light, p, disc.centre, softness);
    if (!window.fits()) return std::nullopt;
    minimise<4>(
        disc, [&](const Disc& at, NormalEquations<4>* equations) { return window.evaluate(at, equations); },
        [](const Disc& at, const Eigen::Vector4d& step) { return at.moved(step); },
        {.most_iterations = round == 0 ? 2 : 8, .tolerance = 1e-3});
    settled = (disc.centre - window.middle()).norm() < kWindowShift;
    if (!settled) continue;
    NormalEquations<4> found;
    const double squares = window.evaluate(disc, &found);
    result.contrast = disc.contrast();
    result.residual = std::sqrt(squares / window.pixels()) / std::max(disc.contrast(), 1e-9);
    result.centre = disc.centre;
    result.covariance =
        found.JtJ.inverse().topLeftCorner<2, 2>() * (squares / std::max(1, window.pixels() - 4));
  }
  if (!settled || !disc.centre.allFinite() || !(result.contrast >= settings.least_contrast))
    return std::nullopt;
  if (disc.ground > settings.most_ground * disc.bright)
    return std::nullopt;  // bright, but not in a dark ring
  if ((result.centre - p.centre).norm() > settings.search_px + 1.0) return std::nullopt;
  // A disc within one pixel stays as bright wherever in it: nothing tells its place, and no fit's covariance
  // may say that it is known, nor be infinite.
  if (!(result.covariance.determinant() > 0.0 && result.covariance.trace() < kNoPlace * kNoPlace))
    return std::nullopt;
  result.covariance += kModel * kModel * Eigen::Matrix2d::Identity();
  return result;
}

// A landmark in view, and where a disc stands out most.
struct Candidate {
  std::size_t landmark;
  Prediction prediction;
  Patch light;
  device::Pixel start;
};

std::vector<LandmarkSighting> fit_all(const std::vector<Candidate>& candidates, double softness,
                                      const LandmarkDetectorSettings& settings) {
  std::vector<LandmarkSighting> fits;
  for (const auto& [landmark, prediction, light, start] : candidates) {
    auto found = fit(light, prediction, start, softness, settings);
    if (!found) continue;
    found->landmark = landmark;
    fits.push_back(*found);
  }
  return fits;
}

double median_residual(const std::vector<LandmarkSighting>& fits) {
  std::vector<double> residuals;
  for (const auto& sighting : fits) residuals.push_back(sighting.residual);
  return residuals.empty() ? std::numeric_limits<double>::infinity() : median(std::move(residuals));
}

// All of one picture are equally soft. What fits worse than the others stays what it is: half hidden, or no landmark.
std::vector<LandmarkSighting> best_fits(const std::vector<Candidate>& candidates,
                                        const LandmarkDetectorSettings& settings) {
  std::vector<LandmarkSighting> best = fit_all(candidates, kSoftness.front(), settings);
  double least = median_residual(best);
  if (least <= kSharp) return best;
  for (auto softness = kSoftness.begin() + 1; softness != kSoftness.end(); ++softness) {
    auto softer = fit_all(candidates, *softness, settings);
    const double residual = median_residual(softer);
    if (softer.size() < best.size() || residual >= least) continue;
    best = std::move(softer);
    least = residual;
  }
  return best;
}

}  // namespace

std::vector<LandmarkSighting> detect_landmarks(const device::CameraImage& image,
                                               const device::CameraModel& camera,
                                               const Pose<World, CameraOptical>& X_world_camera,
                                               std::span<const rig::Landmark> landmarks,
                                               const LandmarkDetectorSettings& settings) {
  if (image.width != camera.width || image.height != camera.height ||
      image.rgb.size() !=
          static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) * 3) {
    throw std::invalid_argument("landmarks: image and camera differ in size");
  }
  std::array<double, 256> linear{};
  for (std::size_t i = 0; i < 256; ++i)
    linear[i] = light_of(static_cast<double>(i) / 255.0, settings.encoding);
  const Pose<CameraOptical, World> X = X_world_camera.inverse();
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto prediction = predict(camera, X, landmarks[i]);
    if (!prediction || prediction->short_axis < settings.least_radius_px) continue;
    const double margin = settings.search_px + 3.0;
    const Patch light(image, linear, prediction->centre, kWindow * prediction->radii.row(0).norm() + margin,
                      kWindow * prediction->radii.row(1).norm() + margin);
    const auto start = coarse(light, *prediction, settings.search_px);
    if (start) candidates.push_back({i, *prediction, light, *start});
  }
  auto sightings = best_fits(candidates, settings);
  std::erase_if(sightings,
                [&](const LandmarkSighting& s) { return !(s.residual <= settings.most_residual); });
  return sightings;
}

int predicted_landmarks(const device::CameraModel& camera, const Pose<World, CameraOptical>& X_world_camera,
                        std::span<const rig::Landmark> landmarks) {
  const Pose<CameraOptical, World> X = X_world_camera.inverse();
  int count = 0;
  for (const rig::Landmark& mark : landmarks) count += predict(camera, X, mark).has_value() ? 1 : 0;
  return count;
}

}  // namespace palpate::vision
