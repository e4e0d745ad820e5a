// From the camera's numbers to the picture, beside another renderer: POV-Ray's rays through the same scene, its bodies and
// its camera written out without our code (golden_pictures/trace.py). Two real things hide parts of two bodies.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "tests/picture_scene_for_tests.h"

namespace palpate {
namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr double kImage = 180.0;  // the camera's image, everywhere
using Rgb = std::vector<std::uint8_t>;

// Matt, without blue: what blue is left in a pixel is the image's, and tells how much of it the body covers.
constexpr scene::Look matt(float red, float green) { return {{red, green, 0.0f}, 0.0f, 0.0f, 0.0f}; }

scene::DrawItem placed(const scene::TriangleMesh& mesh, const scene::Look& look, const Vector3& axis,
                       double angle, const Vector3& place) {
  scene::DrawItem item = item_at(mesh, place, look);
  item.rotation = Quaternion(Eigen::AngleAxisd(angle, axis.normalized()));
  return item;
}

// What is varied against the traced picture, which has none of it.
struct Wrong {
  double cx = 0.0, cy = 0.0, focus = 1.0;
  Vector3 turned = Vector3::Zero(), shifted = Vector3::Zero();  // of the camera, its axes
};

Rgb drawn(const Wrong& wrong = {}) {
  // The lens bends the camera's image only, and this one is the same everywhere.
  const device::CameraModel camera{kWidth,
                                   kHeight,
                                   560 * wrong.focus,
                                   561.5 * wrong.focus,
                                   318.7 + wrong.cx,
                                   242.1 + wrong.cy,
                                   {-0.2, 0.05, 0.001, -0.001, 0.0}};
  const auto X = looking({0.02, -0.95, 2.30}, {0.0, -1.45, 1.40}) *
                 Pose<CameraOptical, CameraOptical>{so3_exp(wrong.turned), wrong.shifted};
  // So fine that facets lie 0.01 px inside the round bodies at most.
  const auto ball = scene::sphere_mesh(0.10, 120, 240);
  const auto disc = scene::disc_mesh(0.10, 0.01, 240);
  const auto block = scene::box_mesh({-0.08, -0.06, -0.05}, {0.08, 0.06, 0.05});
  const auto slab = scene::box_mesh({-0.06, -0.05, -0.06}, {0.06, 0.05, 0.06});
  const auto real_box = scene::box_mesh({0.02, -1.52, 1.30}, {0.12, -1.20, 1.40});
  render::RealScene real = real_scene(false);
  real.bodies.push_back({&real_box, Quaternion::Identity(), Vector3::Zero()});
  const std::vector<scene::DrawItem> items{
      placed(ball, matt(0.6f, 0.25f), Vector3::UnitX(), 0.0, {-0.20, -1.40, 1.35}),
      placed(block, matt(0.65f, 0.1f), {1, 2, 0.5}, 0.7, {0.17, -1.40, 1.45}),
      placed(slab, matt(0.3f, 0.3f), {0.2, 1, -0.3}, 0.9, {-0.06, -1.52, 1.60}),
      placed(disc, matt(0.1f, 0.65f), {1, 0.1, 0.4}, 1.0, {0.0, -1.25, 1.20})};
  render::CompositorSettings settings;
  settings.samples = 8;
  settings.shadows = false;
  settings.light = {{0.45, 0.55, 1.95}, 0.11, 0.95, 0.42};
  render::Compositor compositor(settings);
  Rgb rgb;
  compositor.draw(even_image(camera, static_cast<std::uint8_t>(kImage)), camera, X, items, real, rgb);
  return rgb;
}

Rgb traced() {
  const std::string path = std::filesystem::path(PALPATE_GOLDEN_PICTURES) / "traced.png";
  const cv::Mat bgr = cv::imread(path, cv::IMREAD_COLOR);
  EXPECT_TRUE(bgr.cols == kWidth && bgr.rows == kHeight) << path;
  Rgb rgb(3 * kWidth * kHeight);
  for (int v = 0; v < bgr.rows; ++v)
    for (int u = 0; u < bgr.cols; ++u)
      for (int c = 0; c < 3; ++c)
        rgb[static_cast<std::size_t>(3 * (v * kWidth + u) + c)] = bgr.at<cv::Vec3b>(v, u)[2 - c];
  return rgb;
}

struct Window {
  const char* body;
  int left, top, right, bottom;
};
constexpr Window kFree[] = {
    {"ball", 145, 140, 280, 270}, {"block", 345, 155, 495, 310}, {"disc", 260, 40, 390, 170}};
constexpr Window kSunk{"slab", 210, 272, 355, 395};

double covered(const Rgb& rgb, int u, int v) {
  const double blue = rgb[static_cast<std::size_t>(3 * (v * kWidth + u) + 2)] / kImage;
  return 1.0 - blue * blue;  // bytes hold the root of light
}

// Where a body begins and ends along a row or a column, px: it is whole between, and each pixel tells its share.
struct Chord {
  double from = 0.0, to = 0.0;
};
template <typename Share>
Chord chord(int first, int last, const Share& share) {
  double length = 0.0, moment = 0.0;
  for (int i = first; i <= last; ++i) length += share(i), moment += i * share(i);
  const double middle = moment / std::max(length, 1e-9);
  return {middle - 0.5 * length, middle + 0.5 * length};
}

// Ours against theirs, px.
struct Outline {
  double shift_u = 0.0, shift_v = 0.0, rms = 0.0, overlap = 0.0;
};
Outline compared(const Rgb& ours, const Rgb& theirs, const Window& w) {
  Outline out;
  double squares = 0.0, both = 0.0, either = 0.0;
  int edges = 0;
  const auto add = [&](const Chord& a, const Chord& b, double& shift, int& count) {
    // Where the edge runs along the row a pixel's share says little of it.
    if (std::min(a.to - a.from, b.to - b.from) < 8.0) return;
    shift += 0.5 * (a.from - b.from + a.to - b.to), ++count;
    squares += std::pow(a.from - b.from, 2) + std::pow(a.to - b.to, 2), edges += 2;
  };
  int rows = 0, columns = 0;
  for (int v = w.top; v <= w.bottom; ++v) {
    const auto of = [&](const Rgb& rgb) {
      return chord(w.left, w.right, [&](int u) { return covered(rgb, u, v); });
    };
    add(of(ours), of(theirs), out.shift_u, rows);
    for (int u = w.left; u <= w.right; ++u) {
      const double a = covered(ours, u, v), b = covered(theirs, u, v);
      both += std::min(a, b), either += std::max(a, b);
    }
  }
  for (int u = w.left; u <= w.right; ++u) {
    const auto of = [&](const Rgb& rgb) {
      return chord(w.top, w.bottom, [&](int v) { return covered(rgb, u, v); });
    };
    add(of(ours), of(theirs), out.shift_v, columns);
  }
  EXPECT_GT(rows, 40) << w.body;
  EXPECT_GT(columns, 40) << w.body;
  out.shift_u /= rows, out.shift_v /= columns;
  out.rms = std::sqrt(squares / edges);
  out.overlap = both / either;
  return out;
}

void tell(const Window& window, const Outline& o) {
  std::printf("[ traced ] %s: %+.3f %+.3f px, edges %.3f px rms, overlap %.4f\n", window.body, o.shift_u,
              o.shift_v, o.rms, o.overlap);
}

// Whether every body is where it belongs. Eight samples a pixel, ours, place an edge to 0.13 px (rms) and the mean of
// hundreds of edges to 0.01 px; the limits leave room for the sample places of other drivers.
testing::AssertionResult in_place(const Rgb& ours, const Rgb& theirs) {
  auto result = testing::AssertionSuccess();
  for (const Window& window : kFree) {
    const Outline o = compared(ours, theirs, window);
    tell(window, o);
    if (std::abs(o.shift_u) > 0.04 || std::abs(o.shift_v) > 0.04 || o.rms > 0.2 || o.overlap < 0.993)
      result = testing::AssertionFailure() << window.body << " lies elsewhere";
  }
  return result;
}

TEST(TracedPicture, BodiesAndWhatHidesThemLieWhereTheRaysSay) { EXPECT_TRUE(in_place(drawn(), traced())); }

// Real surfaces are drawn a pixel's step of depth behind themselves, so that what lies on them is not hidden: what is sunk
// in one shows up to a pixel more along its lower edges, half of that in the mean of upper and lower.
TEST(TracedPicture, ATableHidesWhatIsSunkInIt) {
  const Outline o = compared(drawn(), traced(), kSunk);
  tell(kSunk, o);
  EXPECT_GT(o.shift_v, -0.04);
  EXPECT_LT(o.shift_v, 0.5);
  EXPECT_LT(std::abs(o.shift_u), 0.25);
  EXPECT_LT(o.rms, 1.0);
  EXPECT_GT(o.overlap, 0.98);
}

TEST(TracedPicture, HalfAPixelAMillimetreAndAMilliradianAreSeen) {
  const Rgb rays = traced();
  for (const Wrong& wrong :
       {Wrong{.cx = 0.5}, Wrong{.cy = -0.5}, Wrong{.focus = 1.002}, Wrong{.turned = {0.001, 0, 0}},
        Wrong{.turned = {0, 0.001, 0}}, Wrong{.turned = {0, 0, 0.002}}, Wrong{.shifted = {0.001, 0, 0}},
        Wrong{.shifted = {0, 0.001, 0}}, Wrong{.shifted = {0, 0, 0.002}}})
    EXPECT_FALSE(in_place(drawn(wrong), rays));
}

TEST(TracedPicture, MattBodiesAreAsBrightAsTheRaysSay) {
  const Rgb ours = drawn(), rays = traced();
  double sum = 0.0;
  int count = 0, worst = 0;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      if (covered(ours, u, v) < 0.999 || covered(rays, u, v) < 0.999) continue;
      for (int c = 0; c < 2; ++c) {
        const auto at = static_cast<std::size_t>(3 * (v * kWidth + u) + c);
        const int off = std::abs(ours[at] - rays[at]);
        sum += off, worst = std::max(worst, off), ++count;
      }
    }
  std::printf("[ traced ] colours %.2f levels off in the mean, %d at most, %d values\n", sum / count, worst,
              count);
  EXPECT_GT(count, 20000);
  EXPECT_LT(sum / count, 1.0);
}

}  // namespace
}  // namespace palpate
