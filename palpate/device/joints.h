// Numbers of an arm's joints: angles, torques, gains, one each, base first.
//
// rad, N m. Values of fixed capacity: what the haptic tick does with them takes nothing from the heap. As any
// vector of Eigen otherwise. Throws std::length_error for more than kMostJoints.
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <stdexcept>

namespace palpate::device {

inline constexpr int kMostJoints = 8;

class JointVector : public Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostJoints, 1> {
 public:
  using Base = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostJoints, 1>;

  JointVector() = default;  // of no joint
  JointVector(std::initializer_list<double> values)
      : Base(checked(static_cast<Eigen::Index>(values.size()))) {
    Eigen::Index i = 0;
    for (const double value : values) (*this)[i++] = value;
  }
  template <typename Derived>
  JointVector(const Eigen::MatrixBase<Derived>& other) {  // NOLINT: as vectors of Eigen
    checked(other.size());
    Base::operator=(other);
  }
  template <typename Derived>
  JointVector& operator=(const Eigen::MatrixBase<Derived>& other) {
    checked(other.size());
    Base::operator=(other);
    return *this;
  }
  static JointVector filled(Eigen::Index joints, double value) {
    return Base::Constant(checked(joints), value);
  }

 private:
  static Eigen::Index checked(Eigen::Index joints) {
    if (joints > kMostJoints) throw std::length_error("an arm has at most 8 joints");
    return joints;
  }
};

// theta = gain * psi + offset, joint by joint; psi are the encoder readings.
struct JointCorrection {
  JointVector gain = JointVector::filled(3, 1.0);
  JointVector offset = JointVector::filled(3, 0.0);  // rad
  static JointCorrection none(Eigen::Index joints) {
    return {JointVector::filled(joints, 1.0), JointVector::filled(joints, 0.0)};
  }
  JointVector apply(const JointVector& psi) const { return gain.cwiseProduct(psi) + offset; }
  JointVector undo(const JointVector& theta) const { return (theta - offset).cwiseQuotient(gain); }
};

}  // namespace palpate::device
