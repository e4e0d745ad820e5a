// The coordinate frames of the laboratory, as empty types. docs/conventions.md draws them.
// All are right-handed; lengths in metres.
#pragma once

namespace palpate::inline math {

struct World;  // the optical tracker's frame: +x to the user's right, +y up, +z from the tracker to the user
struct ArmBase;  // frame of the arm's kinematic equations: origin is the tip at reset, axes about as World's
struct Tip;  // stylus: origin at its tip (= haptic interaction point), +z along it, away from what it carries
struct TipMarker;      // rigid body of LEDs on the stylus
struct CameraMarker;   // rigid body of LEDs on the head camera
struct CameraOptical;  // pinhole frame: x right, y down, z forward
struct Pointer;        // rigid body of LEDs on the hand-held pointer
struct Board;          // calibration board: origin at its first inner corner, x along columns, y along rows
struct Bat;            // disc in its own x-z plane, +y out of the front face, origin at the disc's centre
struct Rectangle;  // a real surface: origin at corner 1, x to corner 2, y to corner 4, z out of the surface

}  // namespace palpate::inline math
