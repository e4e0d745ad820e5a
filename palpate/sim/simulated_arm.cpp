#include "palpate/sim/simulated_arm.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "palpate/core/units.h"
#include "palpate/device/arm_kinematics.h"

namespace palpate::sim {
namespace {

constexpr double kUpdateInterval = 0.001;  // s, of joint angles, motor torques and stops
constexpr double kStopMargin = 0.05;       // rad beyond the stated range
constexpr double kStopStiffness = 2000.0;  // N/m at the tip
constexpr double kHollowStiffness = 5e4;   // N/m: 0.04 mm under a press of 2 N
constexpr double kHollowDamping = 100.0;   // N s/m: half of critical for hand and arm together
constexpr double kStretched = 0.9999;      // of both links' length: where the arm itself ends
constexpr double kComfortable = 0.98;      // the same, for what a person reaches for
constexpr double kOnTheArm = 1e-6;         // m
constexpr double kFrictionSpeed = 0.002;   // m/s at which dry friction has taken its full size

}  // namespace

double quantised(double value, double quantum) {
  return quantum > 0.0 ? quantum * std::round(value / quantum) : value;
}

SimulatedArm::SimulatedArm(const config::WorldFile& world, const Truth& truth)
    : lengths_(truth.lengths),
      nominal_{world.arm.lengths[0], world.arm.lengths[1]},
      joints_(truth.joints),
      gimbal_(truth.gimbal),
      delta_(truth.delta),
      X_world_base_(truth.X_world_base),
      X_base_world_(truth.X_world_base.inverse()),
      range_(world.arm.joint_range),
      axis_signs_(Vector3::Ones()),
      exchanged_(world.arm_faults.exchanged_joints),
      torque_gains_(world.arm_faults.torque_gains.data()),
      mass_(world.arm.apparent_mass),
      friction_(world.arm.friction),
      max_force_(world.arm.max_force),
      max_speed_(world.arm.max_speed),
      hysteresis_(world.arm.hysteresis),
      joint_quantum_(world.arm.encoder_quantum),
      gimbal_quantum_(world.arm.gimbal_quantum) {
  if (const int axis = world.arm_faults.mirrored_axis; axis > 0) axis_signs_[axis - 1] = -1.0;
  faulty_ = axis_signs_ != Vector3::Ones() || exchanged_[0] > 0 || torque_gains_ != Vector3::Ones();
  place(X_world_base_.translation, X_world_base_.rotation);
}

void SimulatedArm::place(const Vector3& tip, const Quaternion& orientation) {
  state_ = State{tip, Vector3::Zero(), orientation, Vector3::Zero()};
  theta_ = theta_of(state_);
  followed_ = theta_;
  commanded_.setZero();
  update_joints();
}

Vector3 SimulatedArm::back_in_reach(const Vector3& in_base, double share) const {
  const Vector3 shoulder(0.0, lengths_.l2, -lengths_.l1), out = in_base - shoulder;
  const double stretched = share * (lengths_.l1 + lengths_.l2),
               folded = std::abs(lengths_.l1 - lengths_.l2) / share, distance = out.norm();
  if (distance > stretched) return shoulder + stretched / distance * out;
  if (distance < folded && distance > 0.0) return shoulder + folded / distance * out;
  return in_base;
}

// Where the hand has pulled the tip out of the arm's reach the arm is stretched towards it: its angles follow the hand,
// and do not jump when it comes back.
Vector3 SimulatedArm::theta_of(const State& state) const {
  Vector3 theta = theta_;
  const Vector3 in_base = back_in_reach((X_base_world_ * Point<World>{state.tip}).m, kStretched);
  if (!device::phantom_inverse({in_base}, lengths_, theta)) return theta_;
  return theta;
}

Vector3 SimulatedArm::gimbal_of(const State& state, const Vector3& theta) const {
  return device::phantom_gimbal(theta, X_base_world_.rotation * state.orientation);
}

Vector3 SimulatedArm::joint_readings(const Vector3& theta) const {
  Vector3 felt = theta;
  for (int i = 0; i < 3; ++i)
    felt[i] = std::clamp(followed_[i], theta[i] - 0.5 * hysteresis_, theta[i] + 0.5 * hysteresis_);
  Vector3 psi = joints_.undo(felt);
  for (auto& angle : psi) angle = quantised(angle, joint_quantum_);
  return psi;
}

Vector3 SimulatedArm::readings(const State& state, const Vector3& theta) const {
  if (!delta_) return joint_readings(theta);
  const Vector3 place = (X_base_world_ * Point<World>{state.tip}).m;
  return made_.place(delta_->readings(place, joint_quantum_), place);
}

Vector3 SimulatedArm::gimbal_readings(const State& state, const Vector3& theta) const {
  return gimbal_readings(delta_ ? device::gimbal_angles(X_base_world_.rotation * state.orientation)
                                : gimbal_of(state, theta));
}

Vector3 SimulatedArm::gimbal_readings(const Vector3& gimbal) const {
  Vector3 psi = gimbal_.undo(gimbal);
  for (auto& angle : psi) angle = quantised(angle, gimbal_quantum_);
  return psi;
}

Vector3 SimulatedArm::clamped(const Vector3& theta) const {
  Vector3 inside;
  for (int i = 0; i < 3; ++i) {
    const auto& [low, high] = range_[static_cast<std::size_t>(i)];
    inside[i] = std::clamp(theta[i], low - kStopMargin, high + kStopMargin);
  }
  const double fold = inside[1] - inside[2] - kFoldLimit;
  if (fold > 0.0) {
    inside[1] -= 0.5 * fold;
    inside[2] += 0.5 * fold;
  }
  return inside;
}

bool SimulatedArm::within_range(const Vector3& theta) const { return (clamped(theta) - theta).norm() < 1e-9; }

Vector3 SimulatedArm::within_reach(const Vector3& tip) const {
  const Vector3 in_base = back_in_reach((X_base_world_ * Point<World>{tip}).m, kComfortable);
  Vector3 theta;
  if (!device::phantom_inverse({in_base}, lengths_, theta)) return state_.tip;
  const Vector3 inside = clamped(theta);
  if (inside == theta) return (X_world_base_ * Point<ArmBase>{in_base}).m;
  return (X_world_base_ * device::phantom_tip(inside, lengths_)).m;
}

void SimulatedArm::command(const Vector3& force) {
  // A device that is told nonsense pushes with nothing.
  commanded_ = force.allFinite() ? force : Vector3::Zero();
  const double size = commanded_.norm();
  if (size > max_force_) commanded_ *= max_force_ / size;
  update_joints();  // torques change with the command, not at the next update
  since_update_ = 0.0;
  since_command_ = 0.0;
}

void SimulatedArm::update_joints() {
  theta_ = theta_of(state_);
  for (int i = 0; i < 3; ++i)
    followed_[i] = std::clamp(followed_[i], theta_[i] - 0.5 * hysteresis_, theta_[i] + 0.5 * hysteresis_);

  // The device turns the wanted force into torques with the kinematics it believes in (nominal lengths,
  // readings as angles); those torques act through the true geometry.
  motor_force_.setZero();
  if (commanded_ != Vector3::Zero()) {
    const Vector3 torque =
        faulty_ ? miswired(torques(axis_signs_.cwiseProduct(commanded_))) : torques(commanded_);
    Vector3 real = true_jacobian().transpose().partialPivLu().solve(torque);
    const double size = real.norm();
    if (!real.allFinite()) real.setZero();
    if (size > 2.0 * max_force_)
      real *= 2.0 * max_force_ / size;  // next to the singular line the links give way
    motor_force_ = X_world_base_.rotation * real;
  }
  const Vector3 inside = clamped(theta_);
  stop_force_.setZero();
  const bool reached =
      (device::phantom_tip(theta_, lengths_).m - (X_base_world_ * Point<World>{state_.tip}).m).norm() <
      kOnTheArm;
  if (inside != theta_ || !reached) {
    const Vector3 held = (X_world_base_ * device::phantom_tip(inside, lengths_)).m;
    stop_force_ = kStopStiffness * (held - state_.tip) - 8.0 * state_.velocity;
  }
}

Vector3 SimulatedArm::torques(const Vector3& force) const {
  const Matrix3 own = delta_ ? made_.jacobian(readings(state_, theta_))
                             : device::phantom_jacobian(joint_readings(theta_), nominal_);
  return own.transpose() * force;
}

Matrix3 SimulatedArm::true_jacobian() const {
  if (!delta_) return device::phantom_jacobian(theta_, lengths_);
  return delta_->jacobian((X_base_world_ * Point<World>{state_.tip}).m);
}

// What the motors of an arm that is wired wrongly on purpose make of the wanted torques.
Vector3 SimulatedArm::miswired(const Vector3& torque) const {
  Vector3 real = torque;
  if (exchanged_[0] > 0) std::swap(real[exchanged_[0] - 1], real[exchanged_[1] - 1]);
  return torque_gains_.cwiseProduct(real);
}

void SimulatedArm::step(double h, SimulatedHand& hand) {
  since_update_ += h;
  since_command_ += h;
  if (since_command_ > to_seconds(device::kLongestHold)) commanded_.setZero();  // seen by the next update
  if (since_update_ > kUpdateInterval - 0.5 * h) {
    update_joints();
    since_update_ = 0.0;
  }
  hand.step(h);
  const double mass = mass_ + hand.mass();
  SimulatedHand::Push push = hand.push(state_.tip, mass);
  if (hollow_) {
    push.force += kHollowStiffness * (*hollow_ - state_.tip);
    push.stiffness += kHollowStiffness;
    push.damping += kHollowDamping;
  }
  Vector3 force = push.force + motor_force_ + stop_force_;
  // Dry friction, smoothed around standstill; v / (|v| + v0) keeps tanh out of the loop.
  force -= state_.velocity * (friction_ / (state_.velocity.norm() + kFrictionSpeed));
  // Hand and mass by the trapezoidal rule, with the mean of the velocities before and after: it neither adds
  // energy nor takes any. With the new velocity alone a sampled wall would stay stable a third beyond its
  // limit.
  const Vector3 mean =
      (2.0 * mass / h * state_.velocity + force) / (2.0 * mass / h + 0.5 * h * push.stiffness + push.damping);
  const Vector3 before = state_.velocity;
  state_.velocity = 2.0 * mean - before;
  const double speed = state_.velocity.norm();
  if (speed > max_speed_) state_.velocity *= max_speed_ / speed;
  state_.tip += 0.5 * h * (before + state_.velocity);

  if (hand.grip() != Grip::none) {
    // Twice the sine of half the angle, about its axis: the rotation vector for small angles, softer for
    // large ones, and no trigonometry four thousand times a second. A step turns by less than a hundredth, so
    // first order is enough.
    const Quaternion to_go = hand.orientation() * state_.orientation.conjugate();
    const Vector3 error = (to_go.w() < 0.0 ? -2.0 : 2.0) * to_go.vec();
    state_.spin += h * (kTurnRate * kTurnRate * error - 2.0 * kTurnRate * state_.spin);
    const Vector3 half = 0.5 * h * state_.spin;
    state_.orientation = (Quaternion(1.0, half.x(), half.y(), half.z()) * state_.orientation).normalized();
  } else {
    state_.spin.setZero();
  }
}

}  // namespace palpate::sim
