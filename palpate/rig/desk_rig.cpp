// The rig that `palpate rig webcam` writes.
#include "palpate/rig/rig.h"

#include <cmath>

namespace palpate::rig {
namespace {

// As in the reference laboratory: the table's near edge and its height, and the arm above it.
constexpr double kTableTop = -1.52, kNearEdge = 1.80;  // m, World y and z
const Vector3 kArmBase(0.10, -1.40, 1.75);
constexpr double kWallHeight = 0.6, kBoardFromEdge = 0.10;  // m

SurfaceCalibration rectangle(const std::string& name, const Vector3& corner, const Vector3& x,
                             const Vector3& y) {
  SurfaceCalibration surface;
  surface.name = name;
  Matrix3 R;
  R << x.normalized(), y.normalized(), x.cross(y).normalized();
  surface.X_world_rectangle = {Quaternion(R), corner};
  surface.width = x.norm();
  surface.height = y.norm();
  surface.from.method = "desk";
  return surface;
}

}  // namespace

double as_filed(double length) { return 1e-3 * (std::round(1e6 * length) / 1e3); }

Rig desk_rig(const device::CharucoBoard& board, double width, double length) {
  Rig rig;
  rig.name = "desk";
  rig.nominal_arm.lengths = {as_filed(rig.nominal_arm.lengths.l1), as_filed(rig.nominal_arm.lengths.l2)};
  rig.arm.emplace();
  rig.arm->model.name = kMouseArm;
  rig.arm->model.lengths = rig.nominal_arm.lengths;
  rig.arm->X_world_base = {Quaternion::Identity(), kArmBase.unaryExpr(&as_filed)};
  rig.arm->from.method = "none: it is computed";
  const Vector3 across(width, 0.0, 0.0), away(0.0, 0.0, -length), up(0.0, kWallHeight, 0.0);
  const Vector3 near_left(-0.5 * width, kTableTop, kNearEdge);
  rig.surfaces = {rectangle("table", near_left, across, away),
                  rectangle("wall", near_left + away, across, up)};
  // The sheet's lower edge faces the camera: Board x is World x, y comes towards the person, z goes into the
  // table.
  Matrix3 R;
  R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Quaternion turn(R);
  const Vector3 middle(0.0, kTableTop, kNearEdge - kBoardFromEdge - 0.5 * board.rows * board.square);
  rig.board = BoardPlacement{board, {turn, middle - turn * board.middle()}};
  return rig;
}

}  // namespace palpate::rig
