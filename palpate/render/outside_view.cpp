#include "palpate/render/outside_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "palpate/render/picture_looks.h"

namespace palpate::render {
namespace {

// Right, up and towards the player, in lengths of the table, from its middle.
const Vector3 kOnlookerStands{-2.45, 0.90, 1.50}, kOnlookerLooks{0.05, 0.0, 0.50};
// Focal length over the picture's height and at most over its width: from the floor to the player's head is
// 36 degrees, from wall to head 46.
constexpr double kFocalOfHeight = 1.55, kFocalOfWidth = 1.16;

constexpr double kOnlookerLowest = 0.03, kOnlookerHighest = 1.48;   // rad above the table
constexpr double kOnlookerFarthest = 1.5, kOnlookerNearest = 0.15;  // of the way at first, of the farthest
constexpr double kOnlookerNotch = 0.9;                              // of the way that is left

constexpr double kSightRadius = 0.0035;  // of the pyramid's edges
constexpr double kMarkHeight = 0.035;    // above its base

// CameraOptical: x right, y down, z forward. The lens' pupil is the origin; the camera sits in front of the
// forehead, which is behind it.
const Vector3 kHeadMiddle{0.0, 0.045, -0.165}, kHeadHalf{0.076, 0.115, 0.098};
constexpr double kBandHalf = 0.011;

scene::TriangleMesh bar(const Vector3& a, const Vector3& b, double radius) {
  return scene::cylinder_mesh(a, b, radius, 8);
}

constexpr double kBodyHalf = 0.036;  // of one alone; of a pair as wide as it leaves room

scene::TriangleMesh camera_body(double half_width) {
  scene::TriangleMesh mesh = scene::box_mesh({-half_width, -0.026, -0.062}, {half_width, 0.026, -0.012});
  scene::append(mesh, scene::cylinder_mesh({0.0, 0.0, -0.012}, {0.0, 0.0, 0.012}, 0.017, 24));
  return mesh;
}

// `between`: where a single camera would sit.
scene::TriangleMesh head(const Vector3& between) {
  scene::TriangleMesh mesh = scene::sphere_mesh(1.0, 20, 32);
  for (auto& v : mesh.vertices) v = between + kHeadMiddle + v.cwiseProduct(kHeadHalf);
  return mesh;
}

// Round the head at the camera's height.
scene::TriangleMesh head_band(const Vector3& between) {
  scene::TriangleMesh mesh = scene::cylinder_mesh({0.0, -kBandHalf, 0.0}, {0.0, kBandHalf, 0.0}, 1.0, 32);
  const double at = -kHeadMiddle.y() / kHeadHalf.y();  // the ellipsoid's own height there
  const double share = std::sqrt(1.0 - at * at) + 0.03;
  for (auto& v : mesh.vertices)
    v = between +
        Vector3(share * kHeadHalf.x() * v.x(), v.y(), kHeadMiddle.z() + share * kHeadHalf.z() * v.z());
  return mesh;
}

scene::TriangleMesh sight(const device::CameraModel& camera) {
  const auto corners = sight_corners(camera);
  scene::TriangleMesh mesh;
  for (std::size_t i = 0; i < 4; ++i) {
    scene::append(mesh, bar(Vector3::Zero(), corners[i], kSightRadius));
    scene::append(mesh, bar(corners[i], corners[(i + 1) % 4], kSightRadius));
  }
  const Vector3 middle = 0.5 * (corners[0] + corners[1]), side = 0.2 * (corners[1] - corners[0]);
  const Vector3 top = middle - Vector3(0.0, kMarkHeight, 0.0);
  scene::append(mesh, bar(middle - side, top, kSightRadius));
  scene::append(mesh, bar(middle + side, top, kSightRadius));
  return mesh;
}

// A table's own directions, and its middle.
struct TableFrame {
  Vector3 right, up, back, middle;
  double width, length;
  Vector3 at(const Vector3& from_middle) const {
    return middle + from_middle.x() * right + from_middle.y() * up + from_middle.z() * back;
  }
};
TableFrame frame_of(const std::array<Vector3, 4>& table) {
  const Vector3 across = table[1] - table[0], along = table[3] - table[0];
  const Vector3 normal = across.cross(along);
  if (normal.norm() < 1e-6)
    throw std::invalid_argument("view from outside: the table's corners span nothing");
  const Vector3 right = across.normalized(), up = normal.normalized();
  return {right,         up,          right.cross(up), 0.25 * (table[0] + table[1] + table[2] + table[3]),
          across.norm(), along.norm()};
}

// Legs as those of a plain table: so far inside of its edges.
constexpr double kLegRadius = 0.021, kBesideLeg = 0.045, kBehindLeg = 0.06;
constexpr double kBoardTop = -0.002, kBoardBelow = -0.026;  // under the surface itself, which is drawn apart
constexpr double kFloorLeft = 1.5, kFloorRight = 1.3, kFloorBehindWall = 0.7,
                 kFloorInFront = 1.3;  // beyond it
constexpr double kShadeAbove = 0.001;  // over the floor, so that it is seen

scene::TriangleMesh flat(const TableFrame& t, const Vector3& low, const Vector3& high) {
  const Vector3 corner = t.at({low.x(), low.y(), high.z()});
  return scene::rectangle_mesh(corner, (high.x() - low.x()) * t.right, -(high.z() - low.z()) * t.back);
}

}  // namespace

Furniture::Furniture(const std::array<Vector3, 4>& table, const Vector3& lamp) {
  const TableFrame t = frame_of(table);
  const double x = 0.5 * t.width, z = 0.5 * t.length;
  floor_ = flat(t, {-x - kFloorLeft, -kTableHeight, -z - kFloorBehindWall},
                {x + kFloorRight, -kTableHeight, z + kFloorInFront});
  legs_ = scene::box_mesh({-x, kBoardBelow, -z}, {x, kBoardTop, z});
  for (auto& v : legs_.vertices) v = t.at(v);
  for (const double side : {-1.0, 1.0})
    for (const double end : {-1.0, 1.0}) {
      const double a = side * (x - kBesideLeg), b = end * (z - kBehindLeg);
      scene::append(
          legs_, scene::cylinder_mesh(t.at({a, -kTableHeight, b}), t.at({a, kBoardTop, b}), kLegRadius, 16));
    }
  // From a lamp the shade of a flat thing on a floor parallel to it is that thing, enlarged.
  const double above = t.up.dot(lamp - t.middle);
  if (above <= 0.1) return;
  const double larger = (above + kTableHeight - kShadeAbove) / above;
  const auto shade = [&](const Vector3& p) -> Vector3 { return lamp + larger * (p - lamp); };
  shade_ = scene::rectangle_mesh(shade(table[0]), larger * t.width * t.right, -larger * t.length * t.back);
}

std::vector<scene::DrawItem> Furniture::items() const {
  std::vector<scene::DrawItem> items;
  const auto add = [&](const scene::TriangleMesh& mesh, const scene::Look& look) {
    if (!mesh.triangles.empty())
      items.push_back({&mesh, look, Quaternion::Identity(), Vector3::Zero(), false});
  };
  add(floor_, kFloorLook);
  add(shade_, kFloorShadeLook);
  add(legs_, kFurnitureLook);
  return items;
}

Viewpoint onlooker(const std::array<Vector3, 4>& table, int width, int height) {
  const TableFrame t = frame_of(table);
  const Vector3& up = t.up;
  const auto place = [&](const Vector3& from) -> Vector3 { return t.at(t.length * from); };
  const Vector3 eye = place(kOnlookerStands);
  const Vector3 z = (place(kOnlookerLooks) - eye).normalized(), x = z.cross(up).normalized();
  Matrix3 R;
  R << x, z.cross(x), z;
  device::CameraModel camera;
  camera.width = width, camera.height = height;
  camera.fx = camera.fy = std::min(kFocalOfHeight * height, kFocalOfWidth * width);
  camera.cx = 0.5 * (width - 1), camera.cy = 0.5 * (height - 1);
  return {nullptr, camera, {Quaternion(R), eye}};
}

Onlooker::Onlooker(const std::vector<scene::SceneSurface>& surfaces, int width, int height)
    : viewpoint_(onlooker(surfaces, width, height)) {
  const TableFrame t = frame_of(table_of(surfaces).corners);
  target_ = t.at(t.length * kOnlookerLooks);
  back_ = t.back, right_ = t.right, up_ = t.up;
  const Vector3 from = viewpoint_.X_world_camera.translation - target_;
  way_ = from.norm();
  farthest_ = kOnlookerFarthest * way_;
  turned_ = std::atan2(from.dot(right_), from.dot(back_));
  raised_ = std::asin(from.dot(up_) / way_);
}

void Onlooker::walk(double right, double up) {
  turned_ = std::remainder(turned_ + right, 2.0 * std::numbers::pi);
  raised_ = std::clamp(raised_ + up, kOnlookerLowest, kOnlookerHighest);
  look();
}

void Onlooker::approach(double notches) {
  way_ = std::clamp(way_ * std::pow(kOnlookerNotch, notches), kOnlookerNearest * farthest_, farthest_);
  look();
}

void Onlooker::look() {
  const Vector3 level = std::sin(turned_) * right_ + std::cos(turned_) * back_;
  const Vector3 from = std::cos(raised_) * level + std::sin(raised_) * up_;
  const Vector3 z = -from, x = z.cross(up_).normalized();
  Matrix3 R;
  R << x, z.cross(x), z;
  viewpoint_.X_world_camera = {Quaternion(R), target_ + way_ * from};
}

const scene::SceneSurface& table_of(const std::vector<scene::SceneSurface>& surfaces) {
  const auto table =
      std::find_if(surfaces.begin(), surfaces.end(), [](const auto& s) { return s.name == "table"; });
  if (table == surfaces.end() && surfaces.empty())
    throw std::invalid_argument("view from outside: a scene without surfaces; a table is expected");
  return table == surfaces.end() ? surfaces.front() : *table;
}

Viewpoint onlooker(const std::vector<scene::SceneSurface>& surfaces, int width, int height) {
  return onlooker(table_of(surfaces).corners, width, height);
}

std::array<Vector3, 4> sight_corners(const device::CameraModel& camera) {
  const auto through = [&](double u, double v) -> Vector3 {
    return PlayersCamera::kSightLength *
           Vector3((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
  };
  const double right = camera.width - 0.5, below = camera.height - 0.5;  // the last pixel's outer edges
  return {through(-0.5, -0.5), through(right, -0.5), through(right, below), through(-0.5, below)};
}

PlayersCamera::PlayersCamera(const device::CameraModel& camera, bool worn)
    : body_(camera_body(kBodyHalf)), sight_(sight(camera)) {
  if (!worn) return;
  head_ = head(Vector3::Zero());
  scene::append(body_, head_band(Vector3::Zero()));
}

PlayersCamera::PlayersCamera(const device::CameraModel& left, const device::CameraModel& right,
                             const Pose<CameraOptical, rig::RightCamera>& X_left_right)
    : sight_(sight(left)), right_sight_(sight(right)) {
  constexpr double kGap = 0.002;  // between the two bodies, each side of the middle
  const double half = std::min(kBodyHalf, std::max(0.018, 0.5 * X_left_right.translation.norm() - kGap));
  const auto to_left = [&](scene::TriangleMesh mesh) {
    for (auto& v : mesh.vertices) v = (X_left_right * Point<rig::RightCamera>{v}).m;
    return mesh;
  };
  right_sight_ = to_left(std::move(right_sight_));
  const Vector3 between = 0.5 * X_left_right.translation;
  head_ = head(between);
  body_ = camera_body(half);
  scene::append(body_, to_left(camera_body(half)));
  scene::append(body_, head_band(between));
}

std::vector<scene::DrawItem> PlayersCamera::items(const Pose<World, CameraOptical>& X,
                                                  bool right_sees) const {
  std::vector<scene::DrawItem> items;
  if (!head_.triangles.empty()) items.push_back({&head_, kFigureLook, X.rotation, X.translation, true});
  items.push_back({&body_, kCameraLook, X.rotation, X.translation, true});
  items.push_back({&sight_, kSightLook, X.rotation, X.translation, false});
  if (right_sees && !right_sight_.triangles.empty())
    items.push_back({&right_sight_, kSightLook, X.rotation, X.translation, false});
  return items;
}

}  // namespace palpate::render
