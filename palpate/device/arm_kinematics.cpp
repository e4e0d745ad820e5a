#include "palpate/device/arm_kinematics.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace palpate::device {
namespace {

// Of a Premium in the middle of its range |det J| is 0.013 m^3; its links together are 0.42 m long.
constexpr double kLeastOfPhantom = 1e-4;  // m^3
// What is corrected moves with what is stated, nearly one to one: a half lies far beyond any real arm.
constexpr double kLeastOfCartesian = 0.5;
constexpr double kLeastShare =
    kLeastOfPhantom / (0.4191 * 0.4191 * 0.4191);  // of the cube of the links' length

class PhantomKinematics final : public ArmKinematics {
 public:
  explicit PhantomKinematics(const PhantomLengths& lengths) : lengths_(lengths) {}
  int joint_count() const override { return 3; }
  Pose<ArmBase, Tip> pose(const JointVector& theta, const Vector3& gimbal) const override {
    return phantom_pose(theta, gimbal, lengths_);
  }
  TipJacobian jacobian(const JointVector& theta) const override { return phantom_jacobian(theta, lengths_); }
  PoseAndJacobian pose_and_jacobian(const JointVector& theta, const Vector3& gimbal) const override {
    const PhantomTip tip = phantom_tip_and_jacobian(theta, lengths_);
    return {{phantom_stylus(theta, gimbal), tip.place.m}, tip.jacobian};
  }
  JointRange range(int) const override { return {}; }
  double least_manipulability() const override { return kLeastOfPhantom; }

 private:
  PhantomLengths lengths_;
};

class CartesianKinematics final : public ArmKinematics {
 public:
  explicit CartesianKinematics(const ArmModel& model)
      : places_(model.places), correction_(model.correction) {}
  int joint_count() const override { return 3; }
  Pose<ArmBase, Tip> pose(const JointVector& theta, const Vector3& gimbal) const override {
    const Vector3 stated = theta.head<3>();
    return {gimbal_turn(gimbal), stated + correction_.at(stated)};
  }
  TipJacobian jacobian(const JointVector& theta) const override {
    return Matrix3::Identity() + correction_.slope(Vector3(theta.head<3>()));
  }
  PoseAndJacobian pose_and_jacobian(const JointVector& theta, const Vector3& gimbal) const override {
    return {pose(theta, gimbal), jacobian(theta)};
  }
  JointRange range(int joint) const override { return places_[static_cast<std::size_t>(joint)]; }
  double least_manipulability() const override { return kLeastOfCartesian; }

 private:
  std::array<JointRange, 3> places_;
  PlaceCorrection correction_;
};

class DhKinematics final : public ArmKinematics {
 public:
  explicit DhKinematics(const ArmModel& model)
      : count_(static_cast<int>(model.joints.size())), tool_(model.tool), tool_turn_(model.tool_turn) {
    double length = model.tool.norm();
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      const DhJoint& row = model.joints[j];
      links_[j] = {row.a, row.d, row.theta_offset, std::cos(row.alpha), std::sin(row.alpha), row.range};
      length += std::hypot(row.a, row.d);
    }
    least_ = kLeastShare * length * length * length;
  }
  int joint_count() const override { return count_; }

  Pose<ArmBase, Tip> pose(const JointVector& theta, const Vector3& gimbal) const override {
    Walk walk;
    for (int j = 0; j < count_; ++j) step(j, theta[j], walk);
    return pose_after(walk, gimbal);
  }
  TipJacobian jacobian(const JointVector& theta) const override {
    OfJoints axis, place;
    return jacobian_after(walk_noting(theta, axis, place), axis, place);
  }
  PoseAndJacobian pose_and_jacobian(const JointVector& theta, const Vector3& gimbal) const override {
    OfJoints axis, place;
    const Walk walk = walk_noting(theta, axis, place);
    return {pose_after(walk, gimbal), jacobian_after(walk, axis, place)};
  }

  JointRange range(int joint) const override { return links_[static_cast<std::size_t>(joint)].range; }
  double least_manipulability() const override { return least_; }

 private:
  struct Link {
    double a = 0.0, d = 0.0, theta_offset = 0.0, cos_alpha = 1.0, sin_alpha = 0.0;
    JointRange range;
  };

  struct Walk {  // from the base, so far
    Matrix3 R = Matrix3::Identity();
    Vector3 p = Vector3::Zero();
  };
  using OfJoints = std::array<Vector3, kMostJoints>;

  Pose<ArmBase, Tip> pose_after(const Walk& walk, const Vector3& gimbal) const {
    return {Quaternion(walk.R) * tool_turn_ * gimbal_turn(gimbal), walk.p + walk.R * tool_};
  }

  // Notes each joint's axis and a point of it.
  Walk walk_noting(const JointVector& theta, OfJoints& axis, OfJoints& place) const {
    Walk walk;
    for (int j = 0; j < count_; ++j) {
      const auto at = static_cast<std::size_t>(j);
      axis[at] = walk.R.col(2);
      place[at] = walk.p;
      step(j, theta[j], walk);
    }
    return walk;
  }

  // Column j: the axis of joint j crossed with the way from a point of it to the tip.
  TipJacobian jacobian_after(const Walk& walk, const OfJoints& axis, const OfJoints& place) const {
    const Vector3 tip = walk.p + walk.R * tool_;
    TipJacobian J(3, count_);
    for (int j = 0; j < count_; ++j) {
      const auto at = static_cast<std::size_t>(j);
      J.col(j) = axis[at].cross(tip - place[at]);
    }
    return J;
  }

  // Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha), on the right.
  void step(int joint, double angle, Walk& walk) const {
    auto& [R, p] = walk;
    const Link& link = links_[static_cast<std::size_t>(joint)];
    const double c = std::cos(angle + link.theta_offset), s = std::sin(angle + link.theta_offset);
    const Vector3 x = c * R.col(0) + s * R.col(1), y = c * R.col(1) - s * R.col(0), z = R.col(2);
    p += link.a * x + link.d * z;
    R.col(0) = x;
    R.col(1) = link.cos_alpha * y + link.sin_alpha * z;
    R.col(2) = link.cos_alpha * z - link.sin_alpha * y;
  }

  int count_;
  std::array<Link, kMostJoints> links_{};
  Vector3 tool_;
  Quaternion tool_turn_;
  double least_ = 0.0;
};

}  // namespace

Quaternion gimbal_turn(const Vector3& gimbal) {
  return Quaternion(Eigen::AngleAxisd(gimbal[0], Vector3::UnitY()) *
                    Eigen::AngleAxisd(gimbal[1], Vector3::UnitX()) *
                    Eigen::AngleAxisd(gimbal[2], Vector3::UnitZ()));
}

Vector3 gimbal_angles(const Quaternion& turn) {
  const Matrix3 R = turn.toRotationMatrix();
  return {std::atan2(R(0, 2), R(2, 2)), std::asin(std::clamp(-R(1, 2), -1.0, 1.0)),
          std::atan2(R(1, 0), R(1, 1))};
}

double manipulability(const TipJacobian& J) {
  if (J.cols() == 3) return std::abs(Matrix3(J).determinant());
  const Matrix3 squares = J * J.transpose();
  return std::sqrt(std::max(0.0, squares.determinant()));
}

Expected<void> check_runnable(const ArmModel& model) {
  if (model.kind != ArmModel::Kind::dh || (model.joint_count() >= 3 && model.joint_count() <= kMostJoints))
    return {};
  return wrong_use(
      "arm {}: has {} joints; 3 to {} are expected, as fewer reach no volume and more are not carried",
      model.name, model.joint_count(), kMostJoints);
}

std::unique_ptr<const ArmKinematics> make_kinematics(const ArmModel& model) {
  if (const auto fine = check_runnable(model); !fine) throw std::invalid_argument(fine.error().message);
  if (model.kind == ArmModel::Kind::phantom) return std::make_unique<PhantomKinematics>(model.lengths);
  if (model.kind == ArmModel::Kind::cartesian) return std::make_unique<CartesianKinematics>(model);
  return std::make_unique<DhKinematics>(model);
}

}  // namespace palpate::device
