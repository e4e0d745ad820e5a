#include "palpate/device/phantom.h"

#include <algorithm>
#include <cmath>

namespace palpate::device {

PhantomTip phantom_tip_and_jacobian(const Vector3& theta, const PhantomLengths& lengths) {
  const double s1 = std::sin(theta[0]), c1 = std::cos(theta[0]);
  const double s2 = std::sin(theta[1]), c2 = std::cos(theta[1]);
  const double s3 = std::sin(theta[2]), c3 = std::cos(theta[2]);
  const double reach = lengths.l1 * c2 + lengths.l2 * s3;
  PhantomTip tip;
  tip.place.m = {s1 * reach, lengths.l2 - lengths.l2 * c3 + lengths.l1 * s2, -lengths.l1 + c1 * reach};
  tip.jacobian << c1 * reach, -s1 * lengths.l1 * s2, s1 * lengths.l2 * c3,  //
      0.0, lengths.l1 * c2, lengths.l2 * s3,                                //
      -s1 * reach, -c1 * lengths.l1 * s2, c1 * lengths.l2 * c3;
  return tip;
}

Point<ArmBase> phantom_tip(const Vector3& theta, const PhantomLengths& lengths) {
  return phantom_tip_and_jacobian(theta, lengths).place;
}

Matrix3 phantom_jacobian(const Vector3& theta, const PhantomLengths& lengths) {
  return phantom_tip_and_jacobian(theta, lengths).jacobian;
}

namespace {
Quaternion forearm(const Vector3& theta) {
  return Quaternion(Eigen::AngleAxisd(theta[0], Vector3::UnitY()) *
                    Eigen::AngleAxisd(-theta[2], Vector3::UnitX()));
}
}  // namespace

Quaternion phantom_stylus(const Vector3& theta, const Vector3& gimbal) {
  return forearm(theta) * Quaternion(Eigen::AngleAxisd(gimbal[0], Vector3::UnitY()) *
                                     Eigen::AngleAxisd(gimbal[1], Vector3::UnitX()) *
                                     Eigen::AngleAxisd(gimbal[2], Vector3::UnitZ()));
}

Vector3 phantom_gimbal(const Vector3& theta, const Quaternion& R_base_tip) {
  // R = Ry(a) Rx(b) Rz(c): the middle angle from R(1,2) = -sin b
  const Matrix3 R = (forearm(theta).conjugate() * R_base_tip).toRotationMatrix();
  const double b = std::asin(std::clamp(-R(1, 2), -1.0, 1.0));
  return {std::atan2(R(0, 2), R(2, 2)), b, std::atan2(R(1, 0), R(1, 1))};
}

bool phantom_inverse(const Point<ArmBase>& tip, const PhantomLengths& lengths, Vector3& theta) {
  const double l1 = lengths.l1, l2 = lengths.l2;
  // In the vertical plane through the first axis: reach R = l1 cos t2 + l2 sin t3, height H = l1 sin t2 - l2
  // cos t3.
  const double forward = tip.m.z() + l1;
  const double reach = std::hypot(tip.m.x(), forward);
  const double height = tip.m.y() - l2;
  const double distance2 = reach * reach + height * height;
  const double distance = std::sqrt(distance2);
  if (distance > l1 + l2 || distance < std::abs(l1 - l2) || distance < 1e-9) return false;
  const double beta = std::atan2(height, reach);
  const double gamma =
      std::acos(std::clamp((l1 * l1 + distance2 - l2 * l2) / (2.0 * l1 * distance), -1.0, 1.0));
  theta[0] = std::atan2(tip.m.x(), forward);
  theta[1] = beta + gamma;
  theta[2] = std::atan2(reach - l1 * std::cos(theta[1]), l1 * std::sin(theta[1]) - height);
  return true;
}

}  // namespace palpate::device
