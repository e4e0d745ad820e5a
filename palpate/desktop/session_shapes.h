// What of a guided session can be drawn in space: surfaces, what the person holds, where to hold it.
//
// World frame, m. Pure functions.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpate/desktop/canvas.h"
#include "palpate/desktop/letterbox.h"
#include "palpate/desktop/session_view.h"

namespace palpate::desktop {

// A rod with a marker on it: a stylus, the pointer. `bar`: both ends of a bar at the marker, along the marker's x axis,
// which tells how it is turned about its shaft.
struct RodShape {
  Vector3 tip = Vector3::Zero(), marker = Vector3::Zero();
  std::array<Vector3, 2> bar{Vector3::Zero(), Vector3::Zero()};
};

struct SurfaceShape {
  std::string name;
  std::array<Vector3, 4> corners;
};

struct SessionShapes {
  std::vector<SurfaceShape> surfaces;
  std::vector<Vector3> landmarks;
  std::vector<Vector3> held;        // tips of the poses that were taken
  std::optional<RodShape> present;  // stylus or pointer; its tip is its marker's middle where no tip is known
  std::optional<RodShape> target;   // where to hold the stylus
  std::optional<Vector3> place;     // where to hold the pointer's tip
  std::optional<Vector3> head;      // the camera, or its marker

  // Where the tip is wanted.
  std::optional<Vector3> goal() const {
    if (target) return target->tip;
    return place;
  }
};

SessionShapes shapes_of(const SessionView& view);
// Whether the tip is about where it is wanted: the stylus' as the session judges it, the pointer's to a finger's breadth.
bool is_near_goal(const SessionView& view, const SessionShapes& shapes);

// Which of the markers a request watches.
device::MarkerId watched_marker(const device::Request& request);
// The tip in the stylus' marker as far as it is known; the pointer's.
std::optional<Vector3> stylus_tip(const SessionView& view);

// To a canvas: where a point is drawn; none: it cannot be.
using Projection = std::function<std::optional<Eigen::Vector2d>(const Vector3& world)>;

// Into a picture that is drawn in `box`, through the lens, as the camera's marker stood when it was taken. Nothing where
// that is not known: before lens and hand-eye are calibrated, and while the marker is not seen.
std::optional<Projection> picture_projection(const SessionView& view, const Box& box);

enum class PlanSide : std::uint8_t {
  above,  // x to the right, z, towards the person, down
  front,  // as the person sees it who faces the tracker: x to the right, y up
};
// A plan of the part of the world where something is to be done; on canvases of one size both sides have one scale.
struct Plan {
  Vector3 low = Vector3::Zero(), high = Vector3::Zero();  // World, m
  double pixels_per_metre(Size size) const;
  Projection projection(Size size, PlanSide side) const;
};
// Of whole decimetres, so that it does not creep with the hand.
Plan plan_of(const SessionShapes& shapes);

// `unit`: px, the size of letters beside it. A goal beyond the canvas is an arrow at its edge.
void draw_shapes(Canvas& canvas, const SessionShapes& shapes, const Projection& projection, bool near_goal,
                 double unit);

}  // namespace palpate::desktop
