// Is the simulated arm good enough to judge a coupling by? A sampled virtual spring must go unstable on it
// where theory says: friction, mass, hand, sampling and encoder steps each at its place.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <unsupported/Eigen/MatrixFunctions>

#include "palpate/sim/simulated_arm.h"

namespace palpate::sim {
namespace {

constexpr double kStep = 0.00025;  // s, of the world's integration

struct Held {
  double stiffness = 250.0, damping = 4.0, mass = 0.15;  // of the hand
  double friction = 0.0;                                 // N, of the arm
  double encoder_quantum = 0.0;                          // rad
};

// The stylus held at a place by hand, and a spring that the software renders through readings and motors at a
// fixed rate: force = -stiffness * deflection - damping * its difference per tick, held until the next tick.
class SpringRig {
 public:
  explicit SpringRig(const Held& held) : world_(laboratory(held)), truth_(draw_truth(world_, 1)) {
    place_ = (truth_.X_world_base * device::phantom_tip({0.1, 0.5, 0.3}, truth_.lengths)).m;
    hand_.emplace(HandSettings{.mass = held.mass, .damping = held.damping, .stiffness = held.stiffness},
                  place_, truth_.X_world_base.rotation);
    arm_.place(place_, truth_.X_world_base.rotation);
    hand_->take(Grip::follow, place_, Vector3::Zero());
  }

  // Largest deflection, m, in the last tenth of `seconds` after a nudge to `deflection`.
  double swing(double stiffness, double damping, int steps_per_tick, double deflection, double seconds) {
    const Vector3 along = truth_.X_world_base.rotation * Vector3(1.0, 0.5, -0.5).normalized();
    arm_.place(place_ + deflection * along, truth_.X_world_base.rotation);
    hand_->take(Grip::none, place_, Vector3::Zero());
    hand_->take(Grip::follow, place_, Vector3::Zero());
    const Vector3 centre = truth_.X_world_base.rotation.conjugate() * place_;
    Vector3 before = read();
    double largest = 0.0;
    const int steps = static_cast<int>(seconds / kStep);
    for (int i = 0; i < steps; ++i) {
      if (i % steps_per_tick == 0) {
        const Vector3 now = read();
        const Vector3 rate = (now - before) / (steps_per_tick * kStep);
        arm_.command(-stiffness * (now - base(centre)) - damping * rate);
        before = now;
      }
      arm_.step(kStep, *hand_);
      const double away = (arm_.state().tip - place_).norm();
      if (away > 1e-3) return away;
      if (10 * i > 9 * steps) largest = std::max(largest, away);
    }
    return largest;
  }

  // The smallest stiffness, N/m, at which a nudge grows instead of dying away.
  double limit(int steps_per_tick, double damping = 0.0) {
    double low = 1.0, high = 1e6;
    while (high / low > 1.005) {
      const double middle = std::sqrt(low * high);
      (swing(middle, damping, steps_per_tick, 1e-6, 2.0) > 1e-6 ? high : low) = middle;
    }
    return std::sqrt(low * high);
  }

  double mass() const { return world_.arm.apparent_mass + hand_->mass(); }

 private:
  static config::WorldFile laboratory(const Held& held) {
    auto world = config::reference_world();
    world.arm.gain_sd = world.arm.offset_sd = world.arm.length_sd = world.arm.hysteresis = 0.0;
    world.arm.friction = held.friction;
    world.arm.encoder_quantum = held.encoder_quantum;
    return world;
  }
  Vector3 base(const Vector3& turned) const {
    return turned - truth_.X_world_base.rotation.conjugate() * truth_.X_world_base.translation;
  }
  // ArmBase, through the encoders.
  Vector3 read() const { return device::phantom_tip(arm_.joint_readings(arm_.theta_of(arm_.state()))).m; }

  config::WorldFile world_;
  Truth truth_;
  SimulatedArm arm_{world_, truth_};
  std::optional<SimulatedHand> hand_;
  Vector3 place_;
};

// The same loop on paper: m x'' = -k x - b x' - F, F = K x_n + B (x_n - x_{n-1}) / T held over the tick. The
// exact step matrix of (x, x', x_{n-1}); unstable where an eigenvalue leaves the unit circle (Franklin,
// Powell, Workman 1998, section 4.3).
double theory(double m, double b, double k, double T, double B = 0.0) {
  Eigen::Matrix3d A;
  A << 0.0, 1.0, 0.0, -k / m, -b / m, 1.0 / m, 0.0, 0.0, 0.0;
  const Eigen::Matrix3d step = (A * T).exp();
  const auto radius = [&](double K) {
    Eigen::Matrix3d loop;
    loop << step(0, 0) - step(0, 2) * (K + B / T), step(0, 1), step(0, 2) * B / T,
        step(1, 0) - step(1, 2) * (K + B / T), step(1, 1), step(1, 2) * B / T, 1.0, 0.0, 0.0;
    return loop.eigenvalues().cwiseAbs().maxCoeff();
  };
  double low = 1.0, high = 1e6;
  while (high / low > 1.0001) {
    const double middle = std::sqrt(low * high);
    (radius(middle) > 1.0 ? high : low) = middle;
  }
  return std::sqrt(low * high);
}

TEST(Stability, AStiffSpringGoesUnstableOnTheArmWhereTheSampledLoopDoes) {
  for (const double damping : {1.0, 4.0, 8.0}) {
    for (const int steps_per_tick : {2, 4, 8}) {  // 2 kHz, 1 kHz, 500 Hz
      const Held held{.damping = damping};
      SpringRig rig(held);
      const double T = steps_per_tick * kStep;
      const double expected = theory(rig.mass(), damping, held.stiffness, T);
      // The search ends within 0.5 %; the rest is for the hand's spring and damper, integrated at 4 kHz.
      EXPECT_NEAR(rig.limit(steps_per_tick) / expected, 1.0, 0.015) << damping << " N s/m, tick " << T;
    }
  }
}

TEST(Stability, AVirtualDamperHelpsAsFarAsTheSampledLoopSaysAndThenHarms) {
  const Held held;
  SpringRig rig(held);
  for (const double damping : {0.0, 10.0, 50.0, 200.0}) {
    const double expected = theory(rig.mass(), held.damping, held.stiffness, 0.001, damping);
    EXPECT_NEAR(rig.limit(4, damping) / expected, 1.0, 0.03) << damping << " N s/m";
  }
  EXPECT_GT(rig.swing(100.0, 500.0, 4, 1e-6, 2.0), 1e-5);                           // as far as the motors go
  EXPECT_LT(theory(rig.mass(), held.damping, held.stiffness, 0.001, 500.0), 1.01);  // none at all
}

// Colgate and Schenkel (1997): whatever the hand is, passive only with b > K T / 2 + |B|. A hand that may be
// any spring and mass is met here by the worst of several.
TEST(Stability, NoHandMakesACouplingUnstableThatIsPassive) {
  for (const double T : {0.001, 0.002}) {
    for (const double hand_stiffness : {0.0, 250.0, 2000.0, 20000.0}) {
      for (const double hand_mass : {0.0, 0.15, 2.0}) {
        SpringRig rig({.stiffness = hand_stiffness, .damping = 2.0, .mass = hand_mass});
        EXPECT_GT(rig.limit(static_cast<int>(T / kStep + 0.5)), 0.97 * 2.0 * 2.0 / T)
            << hand_stiffness << " N/m, " << hand_mass << " kg, tick " << T;
      }
    }
  }
}

// Diolaiti, Niemeyer, Barbagli, Salisbury (2006): encoder steps alone keep a spring buzzing; dry friction
// stops that below K = 2 f_c / Delta. An arm without a hand, near enough: it has no other damping.
TEST(Stability, DryFrictionQuietsTheBuzzOfTheEncodersUpToItsLimit) {
  const double quantum = config::reference_world().arm.encoder_quantum,
               friction = config::reference_world().arm.friction;
  const double step = quantum * 0.21;  // m, of the tip
  const double bound = 2.0 * friction / step;
  const Held free{.stiffness = 0.0, .damping = 0.0, .mass = 0.0, .friction = 0.0, .encoder_quantum = quantum};
  Held dry = free;
  dry.friction = friction;
  EXPECT_GT(SpringRig(free).swing(0.5 * bound, 0.0, 4, step, 2.0), 5.0 * step);
  EXPECT_LT(SpringRig(dry).swing(0.5 * bound, 0.0, 4, step, 2.0), 2.0 * step);
  EXPECT_GT(SpringRig(dry).swing(4.0 * bound, 0.0, 4, step, 2.0), 5.0 * step);
}

}  // namespace
}  // namespace palpate::sim
