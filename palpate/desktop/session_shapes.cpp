#include "palpate/desktop/session_shapes.h"

#include <algorithm>
#include <cmath>

#include "palpate/desktop/drawing.h"
#include "palpate/desktop/session_colours.h"

namespace palpate::desktop {
namespace {

using calibration::session::SeenMarker;
using device::Gesture;

constexpr double kBar = 0.03;      // m to either side
constexpr double kSmallest = 0.4;  // m that a plan shows at least
constexpr double kAround = 0.06;   // m around what has to be seen
constexpr double kGrid = 0.1;      // m
constexpr double kFinger = 0.015;  // m
constexpr double kNearest = 0.05;  // m before the camera: nearer a drawing tells nothing

RodShape rod_at(const Vector3& tip, const Quaternion& R_world_marker, const Vector3& tip_in_marker) {
  RodShape rod;
  rod.tip = tip;
  rod.marker = tip - R_world_marker * tip_in_marker;
  const Vector3 aside = R_world_marker * Vector3(kBar, 0.0, 0.0);
  rod.bar = {rod.marker - aside, rod.marker + aside};
  return rod;
}

RodShape rod_of(const SeenMarker& marker, const std::optional<Vector3>& tip_in_marker) {
  const Vector3 tip = tip_in_marker.value_or(Vector3::Zero());
  return rod_at(marker.translation + marker.rotation * tip, marker.rotation, tip);
}

// The place of a touch, where the rig has it by now.
std::optional<Vector3> place_of(const device::Request& request, const rig::Rig& rig) {
  if (request.gesture != Gesture::touch || request.index < 0) return std::nullopt;
  if (const auto* surface = rig.surface(request.what); surface != nullptr && request.index < 4)
    return surface->corner(request.index).m;
  if (request.what == "landmark" && static_cast<std::size_t>(request.index) < rig.landmarks.size())
    return rig.landmarks[static_cast<std::size_t>(request.index)].place.m;
  return std::nullopt;
}

const std::optional<rig::HandEyeCalibration>& hand_eye_of(const SessionView& view) {
  return view.picture && view.picture->right ? view.rig->right_hand_eye : view.rig->hand_eye;
}

}  // namespace

device::MarkerId watched_marker(const device::Request& request) {
  switch (request.gesture) {
    case Gesture::touch:
    case Gesture::swing_pointer:
      return device::MarkerId::pointer;
    case Gesture::look_around_board:
    case Gesture::look:
      return device::MarkerId::camera_marker;
    default:
      return device::MarkerId::tip_marker;
  }
}

std::optional<Vector3> stylus_tip(const SessionView& view) {
  if (view.request && view.request->target) return view.request->target->tip_in_marker;
  if (!view.rig) return std::nullopt;
  if (view.rig->arm) return view.rig->arm->tip_in_marker;
  if (view.rig->tip_pivot) return view.rig->tip_pivot->tip_in_marker;
  return std::nullopt;
}

SessionShapes shapes_of(const SessionView& view) {
  SessionShapes shapes;
  shapes.held = view.held;
  if (view.rig) {
    for (const auto& surface : view.rig->surfaces) {
      SurfaceShape shape{surface.name, {}};
      for (int i = 0; i < 4; ++i) shape.corners[static_cast<std::size_t>(i)] = surface.corner(i).m;
      shapes.surfaces.push_back(shape);
    }
    for (const auto& landmark : view.rig->landmarks) shapes.landmarks.push_back(landmark.place.m);
  }
  const auto& [now_s, arm_answers, stylus, pointer, head, near_target] = view.person;
  if (head.seen) {
    shapes.head = head.translation;
    if (view.rig && view.rig->hand_eye)
      *shapes.head += head.rotation * view.rig->hand_eye->X_marker_camera.translation;
  }
  if (!view.request || view.outcome) return shapes;
  const device::Request& request = *view.request;
  if (request.target)
    shapes.target =
        rod_at(request.target->tip.m, request.target->R_world_marker, request.target->tip_in_marker);
  if (view.rig) shapes.place = place_of(request, *view.rig);
  const auto watched = watched_marker(request);
  if (watched == device::MarkerId::pointer && pointer.seen)
    shapes.present = rod_of(pointer, view.rig && view.rig->pointer_pivot
                                         ? std::optional(view.rig->pointer_pivot->tip_in_marker)
                                         : std::nullopt);
  if (watched == device::MarkerId::tip_marker && stylus.seen)
    shapes.present = rod_of(stylus, stylus_tip(view));
  return shapes;
}

bool is_near_goal(const SessionView& view, const SessionShapes& shapes) {
  if (shapes.target) return view.person.near_target;
  return shapes.place && shapes.present && (shapes.present->tip - *shapes.place).norm() < kFinger;
}

std::optional<Projection> picture_projection(const SessionView& view, const Box& box) {
  if (!view.picture || !view.rig || !view.picture->marker.seen) return std::nullopt;
  const auto& camera = view.picture->right ? view.rig->right_camera : view.rig->camera;
  const auto& hand_eye = hand_eye_of(view);
  const int wide = view.picture->image.width, high = view.picture->image.height;
  if (!camera || !hand_eye || wide <= 0 || high <= 0) return std::nullopt;
  const SeenMarker& marker = view.picture->marker;
  const auto X_camera_world =
      (Pose<World, CameraMarker>{marker.rotation, marker.translation} * hand_eye->X_marker_camera).inverse();
  const double scale_x = static_cast<double>(box.width) / wide,
               scale_y = static_cast<double>(box.height) / high;
  // A pixel's number is its middle; places on a canvas begin at its corner.
  return [lens = camera->model, X_camera_world, box, scale_x, scale_y,
          wide](const Vector3& world) -> std::optional<Eigen::Vector2d> {
    const Vector3 p = (X_camera_world * Point<World>{world}).m;
    if (p.z() < kNearest) return std::nullopt;
    // Far aside a lens model folds back into the picture; without it the direction is right.
    const device::Pixel ideal = lens.project_undistorted(p);
    const bool aside = (ideal - device::Pixel(lens.cx, lens.cy)).norm() > 0.9 * wide;
    const device::Pixel pixel = aside ? ideal : lens.project(p);
    return Eigen::Vector2d(box.x + (pixel.x() + 0.5) * scale_x, box.y + (pixel.y() + 0.5) * scale_y);
  };
}

double Plan::pixels_per_metre(Size size) const {
  const Vector3 span = (high - low).cwiseMax(1e-6);
  return std::min(size.width / span.x(), size.height / std::max(span.y(), span.z()));
}

Projection Plan::projection(Size size, PlanSide side) const {
  const double scale = pixels_per_metre(size);
  const Vector3 middle = 0.5 * (low + high);
  const Eigen::Vector2d centre(0.5 * size.width, 0.5 * size.height);
  return [scale, middle, centre, side](const Vector3& world) -> std::optional<Eigen::Vector2d> {
    const Vector3 from = world - middle;
    const double down = side == PlanSide::above ? from.z() : -from.y();
    return Eigen::Vector2d(centre.x() + scale * from.x(), centre.y() + scale * down);
  };
}

Plan plan_of(const SessionShapes& shapes) {
  Vector3 low = Vector3::Constant(1e9), high = -low;
  const auto hold = [&](const Vector3& place) {
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  };
  for (const auto* rod : {&shapes.present, &shapes.target})
    if (*rod) hold((*rod)->tip), hold((*rod)->marker);
  if (shapes.place) hold(*shapes.place);
  for (const auto& tip : shapes.held) hold(tip);
  // Where nothing is to be done at one place the whole room is shown.
  if (!shapes.target && !shapes.place && shapes.held.empty()) {
    for (const auto& surface : shapes.surfaces)
      for (const auto& corner : surface.corners) hold(corner);
    if (shapes.head) hold(*shapes.head);
  }
  if (low.x() > high.x()) low = high = Vector3::Zero();
  Plan plan;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double middle = 0.5 * (low[k] + high[k]);
    const double half = std::max(0.5 * kSmallest, 0.5 * (high[k] - low[k]) + kAround);
    plan.low[k] = kGrid * std::floor((middle - half) / kGrid);
    plan.high[k] = kGrid * std::ceil((middle + half) / kGrid);
  }
  return plan;
}

namespace {

void draw_rod(Canvas& canvas, const RodShape& rod, const Projection& projection, double unit,
              const Colour& colour) {
  const auto line = [&](const Vector3& a, const Vector3& b, double width, const Colour& with) {
    const auto from = projection(a), to = projection(b);
    if (from && to) draw_line(canvas, *from, *to, width, with);
  };
  // A dark edge keeps it visible before anything bright.
  line(rod.tip, rod.marker, 0.34 * unit, kEdge);
  line(rod.bar[0], rod.bar[1], 0.34 * unit, kEdge);
  line(rod.tip, rod.marker, 0.18 * unit, colour);
  line(rod.bar[0], rod.bar[1], 0.18 * unit, colour);
}

// A cross in a ring.
void draw_goal(Canvas& canvas, const Eigen::Vector2d& at, double unit, const Colour& colour) {
  const double radius = 0.75 * unit, arm = 1.15 * unit;
  for (const auto& [width, ink] : {std::pair(0.36, kEdge), std::pair(0.18, colour)}) {
    draw_ring(canvas, at, radius, width * unit, ink);
    draw_line(canvas, at - Eigen::Vector2d(arm, 0), at + Eigen::Vector2d(arm, 0), 0.8 * width * unit, ink);
    draw_line(canvas, at - Eigen::Vector2d(0, arm), at + Eigen::Vector2d(0, arm), 0.8 * width * unit, ink);
  }
}

// Towards a goal that lies beyond the edge.
void draw_arrow(Canvas& canvas, const Eigen::Vector2d& to, double unit, const Colour& colour) {
  const Eigen::Vector2d middle(0.5 * canvas.width, 0.5 * canvas.height), way = to - middle;
  const Eigen::Vector2d room = middle - Eigen::Vector2d::Constant(1.2 * unit);
  const double shorter =
      std::min(room.x() / std::max(1e-9, std::abs(way.x())), room.y() / std::max(1e-9, std::abs(way.y())));
  const Eigen::Vector2d end = middle + std::min(1.0, shorter) * way, along = way.normalized();
  const Eigen::Vector2d aside(-along.y(), along.x());
  const std::array<Eigen::Vector2d, 3> head{end, end - 1.6 * unit * along + 0.8 * unit * aside,
                                            end - 1.6 * unit * along - 0.8 * unit * aside};
  fill_polygon(canvas, head, colour);
  draw_line(canvas, end - 3.2 * unit * along, end - 1.4 * unit * along, 0.4 * unit, colour);
}

bool is_within(const Canvas& canvas, const Eigen::Vector2d& at) {
  return at.x() >= 0.0 && at.y() >= 0.0 && at.x() < canvas.width && at.y() < canvas.height;
}

void draw_surfaces(Canvas& canvas, const SessionShapes& shapes, const Projection& projection, double unit) {
  for (const auto& surface : shapes.surfaces)
    for (std::size_t i = 0; i < 4; ++i) {
      const auto from = projection(surface.corners[i]), to = projection(surface.corners[(i + 1) % 4]);
      if (from && to) draw_line(canvas, *from, *to, 0.1 * unit, kSurface);
    }
  for (const auto& landmark : shapes.landmarks)
    if (const auto at = projection(landmark)) draw_ring(canvas, *at, 0.22 * unit, 0.09 * unit, kSurface);
}

}  // namespace

void draw_shapes(Canvas& canvas, const SessionShapes& shapes, const Projection& projection, bool near_goal,
                 double unit) {
  draw_surfaces(canvas, shapes, projection, unit);
  for (const auto& tip : shapes.held)
    if (const auto at = projection(tip)) draw_disc(canvas, *at, 0.16 * unit, kHeld);
  const Colour& wanted = near_goal ? kGood : kGoal;
  const auto goal = shapes.goal() ? projection(*shapes.goal()) : std::nullopt;
  const auto tip = shapes.present ? projection(shapes.present->tip) : std::nullopt;
  if (shapes.target) draw_rod(canvas, *shapes.target, projection, unit, wanted);
  if (goal && tip) draw_dashes(canvas, *tip, *goal, 0.12 * unit, 0.45 * unit, wanted);
  if (shapes.present) draw_rod(canvas, *shapes.present, projection, unit, kPresent);
  if (tip) {
    draw_disc(canvas, *tip, 0.42 * unit, kEdge);
    draw_disc(canvas, *tip, 0.32 * unit, kPresent);
  }
  if (!goal) return;
  if (is_within(canvas, *goal))
    draw_goal(canvas, *goal, unit, wanted);
  else
    draw_arrow(canvas, *goal, unit, wanted);
}

}  // namespace palpate::desktop
