#include "palpate/system/outside_view.h"

#include <algorithm>
#include <stdexcept>

namespace palpate {
namespace {

// Right, up and towards the player, in lengths of the table, from its middle.
const Vector3 kOnlookerStands{-1.80, 0.80, 1.00}, kOnlookerLooks{0.05, 0.25, 0.42};
// Focal length over the picture's width: 60 degrees across, as lenses of head cameras have.
constexpr double kOnlookerFocal = 0.875;

constexpr double kSightRadius = 0.0035;  // of the pyramid's edges
constexpr double kMarkHeight = 0.035;    // above its base

// CameraOptical: x right, y down, z forward. The lens' pupil is the origin; the camera sits in front of the
// forehead, which is behind it.
const Vector3 kHeadMiddle{0.0, 0.045, -0.165}, kHeadHalf{0.076, 0.115, 0.098};
constexpr double kBandHalf = 0.011;

TriangleMesh bar(const Vector3& a, const Vector3& b, double radius) { return cylinder_mesh(a, b, radius, 8); }

TriangleMesh camera_body() {
  TriangleMesh mesh = box_mesh({-0.036, -0.026, -0.062}, {0.036, 0.026, -0.012});
  append(mesh, cylinder_mesh({0.0, 0.0, -0.012}, {0.0, 0.0, 0.012}, 0.017, 24));
  return mesh;
}

TriangleMesh head() {
  TriangleMesh mesh = sphere_mesh(1.0, 20, 32);
  for (auto& v : mesh.vertices) v = kHeadMiddle + v.cwiseProduct(kHeadHalf);
  return mesh;
}

// Round the head at the camera's height.
TriangleMesh head_band() {
  TriangleMesh mesh = cylinder_mesh({0.0, -kBandHalf, 0.0}, {0.0, kBandHalf, 0.0}, 1.0, 32);
  const double at = -kHeadMiddle.y() / kHeadHalf.y();  // the ellipsoid's own height there
  const double share = std::sqrt(1.0 - at * at) + 0.03;
  for (auto& v : mesh.vertices)
    v = Vector3(share * kHeadHalf.x() * v.x(), v.y(), kHeadMiddle.z() + share * kHeadHalf.z() * v.z());
  return mesh;
}

TriangleMesh sight(const CameraModel& camera) {
  const auto corners = sight_corners(camera);
  TriangleMesh mesh;
  for (std::size_t i = 0; i < 4; ++i) {
    append(mesh, bar(Vector3::Zero(), corners[i], kSightRadius));
    append(mesh, bar(corners[i], corners[(i + 1) % 4], kSightRadius));
  }
  const Vector3 middle = 0.5 * (corners[0] + corners[1]), side = 0.2 * (corners[1] - corners[0]);
  const Vector3 top = middle - Vector3(0.0, kMarkHeight, 0.0);
  append(mesh, bar(middle - side, top, kSightRadius));
  append(mesh, bar(middle + side, top, kSightRadius));
  return mesh;
}

}  // namespace

Eye onlooker(const std::array<Vector3, 4>& table, int width, int height) {
  const Vector3 across = table[1] - table[0], along = table[3] - table[0];
  const Vector3 normal = across.cross(along);
  if (normal.norm() < 1e-6) throw std::invalid_argument("onlooker: the table's corners span nothing");
  const Vector3 right = across.normalized(), up = normal.normalized(), back = right.cross(up);
  const double length = along.norm();
  const Vector3 middle = 0.25 * (table[0] + table[1] + table[2] + table[3]);
  const auto place = [&](const Vector3& from) -> Vector3 {
    return middle + length * (from.x() * right + from.y() * up + from.z() * back);
  };
  const Vector3 eye = place(kOnlookerStands);
  const Vector3 z = (place(kOnlookerLooks) - eye).normalized(), x = z.cross(up).normalized();
  Matrix3 R;
  R << x, z.cross(x), z;
  CameraModel camera;
  camera.width = width, camera.height = height;
  camera.fx = camera.fy = kOnlookerFocal * width;
  camera.cx = 0.5 * (width - 1), camera.cy = 0.5 * (height - 1);
  return {nullptr, camera, {Quaternion(R), eye}};
}

Eye onlooker(const std::vector<SceneSurface>& surfaces, int width, int height) {
  const auto table =
      std::find_if(surfaces.begin(), surfaces.end(), [](const auto& s) { return s.name == "table"; });
  if (table == surfaces.end() && surfaces.empty())
    throw std::invalid_argument("onlooker: a scene without surfaces; a table is expected");
  return onlooker((table == surfaces.end() ? surfaces.front() : *table).corners, width, height);
}

std::array<Vector3, 4> sight_corners(const CameraModel& camera) {
  const auto through = [&](double u, double v) -> Vector3 {
    return PlayersCamera::kSightLength *
           Vector3((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
  };
  const double right = camera.width - 0.5, below = camera.height - 0.5;  // the last pixel's outer edges
  return {through(-0.5, -0.5), through(right, -0.5), through(right, below), through(-0.5, below)};
}

PlayersCamera::PlayersCamera(const CameraModel& camera, bool worn)
    : body_(camera_body()), sight_(sight(camera)) {
  if (!worn) return;
  head_ = head();
  append(body_, head_band());
}

std::vector<DrawItem> PlayersCamera::items(const Pose<World, CameraOptical>& X) const {
  std::vector<DrawItem> items;
  if (!head_.triangles.empty()) items.push_back({&head_, Material::figure, X.rotation, X.translation, true});
  items.push_back({&body_, Material::camera, X.rotation, X.translation, true});
  items.push_back({&sight_, Material::sight, X.rotation, X.translation, false});
  return items;
}

}  // namespace palpate
