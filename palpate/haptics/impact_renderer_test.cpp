#include "palpate/haptics/impact_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/math/random_vector.h"

namespace palpate::haptics {
namespace {

constexpr scene::ContactModel kModels[] = {scene::ContactModel::non_sticky, scene::ContactModel::paper,
                                           scene::ContactModel::hunt_crossley};
constexpr Duration kPeriods[] = {Duration(1'000'000), Duration(250'000)};
constexpr double kBall = 0.0027;  // kg

scene::ImpactEvent impact_of(scene::ContactModel model, double speed, double restitution, double duration,
                             Instant<PhysicsClock> start) {
  scene::ImpactEvent event;
  event.model = model;
  event.start = start;
  event.duration = seconds(duration);
  event.direction = Vector3(0.1, 0.3, 0.9).normalized();
  event.approach_speed = speed;
  event.mass = kBall;
  event.restitution = restitution;
  return event;
}

Vector3 asked_by(const scene::ImpactEvent& event) {
  return event.mass * (1.0 + event.restitution) * event.approach_speed * event.direction;
}

TEST(ImpactRenderer, TheImpulseOfEveryModelIsExactAtAnyRateAndPhase) {
  Random random(1, "contact_player/phase");
  for (const auto model : kModels)
    for (const auto period : kPeriods)
      for (int run = 0; run < 100; ++run) {
        ImpactRenderer player;
        Instant<PhysicsClock> now{Duration(1'000'000'000)};
        const double e = random.uniform(0.0, 1.0),
                     speed = std::exp(random.uniform(std::log(0.05), std::log(30.0)));
        const auto event = impact_of(model, speed, e, random.uniform(0.0003, 0.007),
                                     now + seconds(random.uniform(0.0, 0.002)));
        ASSERT_TRUE(player.start(event, now));
        const Vector3 requested = asked_by(event);
        Vector3 impulse = Vector3::Zero();
        for (int tick = 0; tick < 100 && player.active(); ++tick, now += period) {
          impulse += to_seconds(period) * player.tick(now, period);
          // What the limiter plans with.
          ASSERT_NEAR((impulse + player.to_come() - requested).norm(), 0.0, 1e-12 * requested.norm());
        }
        EXPECT_FALSE(player.active());
        EXPECT_NEAR((impulse - requested).norm(), 0.0, 1e-12 * requested.norm());
        EXPECT_NEAR((player.requested() - requested).norm(), 0.0, 1e-15);
      }
}

TEST(ImpactRenderer, AnImpactThatBeginsDuringAnotherIsAddedToIt) {
  Random random(2, "contact_player/second");
  for (const auto first : kModels)
    for (const auto second : kModels)
      for (const auto period : kPeriods)
        for (int run = 0; run < 20; ++run) {
          ImpactRenderer player;
          Instant<PhysicsClock> now{Duration(1'000'000'000)};
          const auto one = impact_of(first, 3.0, 0.8, 0.004, now + seconds(random.uniform(0.0, 0.001)));
          auto two = impact_of(second, 5.0, 0.6, 0.004, one.start + seconds(random.uniform(0.0001, 0.0039)));
          two.direction = normal3(random, 1.0).normalized();
          ASSERT_TRUE(player.start(one, now));
          Vector3 impulse = Vector3::Zero();
          bool told = false;
          for (int tick = 0; tick < 100 && (!told || player.active()); ++tick, now += period) {
            if (!told && two.start <= now) {  // heard of a tick late, as the newest message
              told = true;
              ASSERT_TRUE(player.start(two, now));
            }
            impulse += to_seconds(period) * player.tick(now, period);
          }
          const Vector3 requested = asked_by(one) + asked_by(two);
          EXPECT_NEAR((impulse - requested).norm(), 0.0, 1e-12 * requested.norm());
        }
}

// A ball against a spring and damper, step by step: nothing of it knows a closed form.
struct Integrated {
  double step = 2e-7, duration = 0.0, restitution = 0.0, peak = 0.0;
  std::vector<double> speeds;  // m/s inwards, one per step

  double speed_at(double t) const {
    if (t >= duration) return speeds.back();  // its last step is a part of one
    const double at = std::clamp(t / step, 0.0, static_cast<double>(speeds.size() - 1));
    const auto i = std::min(static_cast<std::size_t>(at), speeds.size() - 2);
    return speeds[i] + (at - static_cast<double>(i)) * (speeds[i + 1] - speeds[i]);
  }
};

Integrated integrate(scene::ContactModel model, double k, double damper, double speed) {
  const auto force = [&](double x, double v) {
    if (model == scene::ContactModel::hunt_crossley)
      return k * std::pow(std::max(x, 0.0), 1.5) * (1.0 + damper * v);
    return k * x + damper * v;
  };
  Integrated run;
  const double h = run.step;
  double x = 0.0, v = speed, t = 0.0;
  const auto left = [&] {  // how far it is from its end; the contact is over where this passes 0
    return model == scene::ContactModel::non_sticky ? force(x, v) : x;
  };
  double before = 1.0;
  run.speeds.push_back(v);
  while (true) {
    const auto a = [&](double at, double rate) { return -force(at, rate) / kBall; };
    const double v1 = v, a1 = a(x, v1), v2 = v + 0.5 * h * a1, a2 = a(x + 0.5 * h * v1, v2),
                 v3 = v + 0.5 * h * a2, a3 = a(x + 0.5 * h * v2, v3), v4 = v + h * a3, a4 = a(x + h * v3, v4);
    const double was = v;
    x += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    run.peak = std::max(run.peak, force(x, v));
    if (const double now = left(); now <= 0.0) {
      const double part = before / (before - now);
      run.duration = t + part * h;
      run.restitution = -(was + part * (v - was)) / speed;
      run.speeds.push_back(-run.restitution * speed);
      return run;
    } else {
      before = now;
    }
    t += h;
    run.speeds.push_back(v);
  }
}

TEST(ImpactRenderer, EachTickIsTheMeanForceOfItsModelAsItsEquationOfMotionHasIt) {
  struct Law {
    scene::ContactModel model;
    double stiffness, damper, speed, tolerance;  // of the peak
  };
  Random random(3, "contact_player/course");
  // The closed forms are exact; the end of the integrated motion is met to 1e-6 of its length. Hunt and
  // Crossley's course is itself integrated, in 256 steps.
  for (const auto& law : {Law{scene::ContactModel::non_sticky, 1520.0, 0.30, 1.0, 1e-5},
                          Law{scene::ContactModel::non_sticky, 26000.0, 3.5, 4.0, 1e-5},
                          Law{scene::ContactModel::paper, 1674.0, 0.30, 1.0, 1e-5},
                          Law{scene::ContactModel::paper, 26800.0, 4.0, 4.0, 1e-5},
                          Law{scene::ContactModel::hunt_crossley, 22602.0, 0.02257, 5.0, 2e-4},
                          Law{scene::ContactModel::hunt_crossley, 90000.0, 0.4, 2.0, 2e-4}}) {
    const auto truth = integrate(law.model, law.stiffness, law.damper, law.speed);
    for (const auto period : kPeriods)
      for (int run = 0; run < 10; ++run) {
        ImpactRenderer player;
        Instant<PhysicsClock> now{Duration(1'000'000'000)};
        auto event = impact_of(law.model, law.speed, truth.restitution, truth.duration,
                               now + seconds(random.uniform(0.0, 0.001)));
        ASSERT_TRUE(player.start(event, now));
        while (player.active()) {
          const double from = to_seconds(now - event.start), until = from + to_seconds(period);
          const double mean = kBall *
                              (truth.speed_at(from) - truth.speed_at(std::min(until, truth.duration))) /
                              to_seconds(period);
          ASSERT_NEAR(player.tick(now, period).dot(event.direction), mean, law.tolerance * truth.peak)
              << static_cast<int>(law.model) << " at " << from;
          now += period;
        }
      }
  }
}

// The table of docs/theory/forces.md, worked out apart from this code; tolerance: half of its last digit.
TEST(ImpactRenderer, TheThreeCoursesAreThoseOfTheTable) {
  struct Row {
    scene::ContactModel model;
    double mean[8];  // N, of each half millisecond
  };
  for (const auto& row :
       {Row{scene::ContactModel::non_sticky, {0.655, 1.261, 1.664, 1.820, 1.721, 1.395, 0.898, 0.306}},
        Row{scene::ContactModel::paper, {0.691, 1.354, 1.780, 1.918, 1.763, 1.354, 0.765, 0.095}},
        Row{scene::ContactModel::hunt_crossley, {0.319, 1.324, 2.145, 2.272, 1.823, 1.164, 0.553, 0.119}}}) {
    ImpactRenderer player;
    Instant<PhysicsClock> now{Duration(1'000'000'000)};
    const auto event = impact_of(row.model, 1.0, 0.8, 0.004, now);
    ASSERT_TRUE(player.start(event, now));
    constexpr Duration kHalf(500'000);
    for (const double mean : row.mean) {
      EXPECT_NEAR(player.tick(now, kHalf).dot(event.direction), mean, 6e-4) << static_cast<int>(row.model);
      now += kHalf;
    }
  }
}

TEST(ImpactRenderer, ThePapersImpactPullsAtItsEndAndTheOthersNever) {
  for (const auto model : kModels) {
    ImpactRenderer player;
    Instant<PhysicsClock> now{Duration(1'000'000'000)};
    const auto event = impact_of(model, 1.0, 0.8, 0.004, now);
    ASSERT_TRUE(player.start(event, now));
    double least = 0.0;
    for (constexpr Duration period(50'000); player.active(); now += period)
      least = std::min(least, player.tick(now, period).dot(event.direction));
    if (model == scene::ContactModel::paper) {
      EXPECT_NEAR(least, -0.24, 0.04);  // b e v = 0.241 N in the last moment
    } else {
      EXPECT_GT(least, -1e-9);
    }
  }
}

}  // namespace
}  // namespace palpate::haptics
