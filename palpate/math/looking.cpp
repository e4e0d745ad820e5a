#include "palpate/math/looking.h"

namespace palpate::inline math {

Pose<World, CameraOptical> looking(const Vector3& eye, const Vector3& target) {
  const Vector3 z = (target - eye).normalized();
  Vector3 x = z.cross(Vector3::UnitY());
  if (x.norm() < 1e-6) x = Vector3::UnitX();  // straight up or down
  x.normalize();
  Matrix3 R;
  R << x, z.cross(x), z;
  return {Quaternion(R), eye};
}

}  // namespace palpate::inline math
