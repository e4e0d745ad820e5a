// An application from outside the tree whose surface deforms (examples/jelly): its motion against what is known
// otherwise, its force in the haptic tick, and a play through the whole system with the surface in the picture.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "examples/jelly/application.h"
#include "examples/jelly/settings.h"
#include "examples/jelly/specification.h"
#include "palpate/scene/shape_history.h"
#include "palpate/server/graphics/frame_renderer.h"
#include "palpate/server/physics/physics_server.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/lockstep/lockstep_play.h"
#include "palpate/sim/truth_rig.h"
#include "tests/allocation_count.h"

namespace palpate {
namespace {

using jelly::Contact, jelly::SoftBody;

const std::vector<Vector3>& facing() {
  static const std::vector<Vector3> directions = [] {
    auto areas = jelly::areas_of(jelly::mould());
    for (auto& area : areas) area.normalize();
    return areas;
  }();
  return directions;
}

Contact meet(const SoftBody& body, const Vector3& tip) {
  jelly::Surface surface;
  body.copy_to(surface);
  return jelly::meet(surface, facing(), tip, jelly::kTipRadius);
}

const Vector3 kTop(0.0, jelly::kHeight, 0.0);

double largest_move(const SoftBody& body) {
  double most = 0.0;
  for (std::size_t i = 0; i < jelly::kVertices; ++i)
    most = std::max(most, (body.place(i) - body.rest().vertices[i]).norm());
  return most;
}

TEST(Jelly, MouldIsAClosedDomeOfEvenTrianglesThatFaceOutwards) {
  const auto mesh = jelly::mould();
  ASSERT_EQ(mesh.vertices.size(), jelly::kVertices);
  EXPECT_EQ(mesh.triangles.size(), 6 * jelly::kRings * jelly::kRings);
  // Euler: one sheet with one rim.
  EXPECT_EQ(static_cast<long>(mesh.vertices.size()) - static_cast<long>(jelly::edges_of(mesh).size()) +
                static_cast<long>(mesh.triangles.size()),
            1);
  double volume = 0.0;  // the base is flat, at height 0
  for (const auto& t : mesh.triangles) {
    const Vector3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    volume += a.dot(b.cross(c)) / 6.0;
    EXPECT_GT((b - a).cross(c - a).dot(jelly::outward((a + b + c) / 3.0)), 0.0);
  }
  EXPECT_NEAR(volume, 0.43e-3, 0.05e-3) << "m^3: as heavy as 0.4 kg of water";
}

TEST(Jelly, ComesToRestUnderALoadWhereTheSpringsBalanceItAndSpringsBack) {
  SoftBody body({});
  const Contact on_top = meet(body, kTop);
  const Vector3 load(0.0, -1.0, 0.0);
  for (int ms = 0; ms < 4000; ++ms) body.advance(1e-3, on_top, load);
  EXPECT_LT(body.kinetic_energy(), 1e-9);
  const double once = largest_move(body);
  EXPECT_GT(once, 0.002);
  EXPECT_LT(once, 0.015);
  // Linear: twice the load, twice the dent.
  for (int ms = 0; ms < 4000; ++ms) body.advance(1e-3, on_top, 2.0 * load);
  EXPECT_NEAR(largest_move(body), 2.0 * once, 1e-6);
  for (int ms = 0; ms < 4000; ++ms) body.advance(1e-3, {}, Vector3::Zero());
  EXPECT_LT(largest_move(body), 1e-7);
}

TEST(Jelly, KeepsItsVolumeForWhatIsPressedInComesOutElsewhere) {
  SoftBody body({});
  const Contact on_top = meet(body, kTop);
  for (int ms = 0; ms < 3000; ++ms) body.advance(1e-3, on_top, {0.0, -1.5, 0.0});
  double pressed_in = 0.0;
  const auto areas = jelly::areas_of(body.rest());
  for (std::size_t i = 0; i < jelly::kVertices; ++i)
    pressed_in += std::max(0.0, -areas[i].dot(body.place(i) - body.rest().vertices[i]));
  EXPECT_GT(pressed_in, 3e-7);
  EXPECT_LT(std::abs(body.volume_gained()), 0.25 * pressed_in) << "without air all of it would be lost";
}

TEST(Jelly, IsStableAtTheEndsOfItsSettingsAfterABlowAndAStall) {
  for (const double firmness : {0.3, 2.5})
    for (const double damping : {0.02, 1.0}) {
      SoftBody body({firmness, damping});
      const Contact on_top = meet(body, kTop);
      body.advance(1e-3, on_top, {0.0, -200.0, 0.0});
      double most = body.kinetic_energy();
      for (int ms = 0; ms < 3000; ++ms) {
        body.advance(ms == 500 ? 1.0 : 1e-3, {}, Vector3::Zero());
        EXPECT_LE(body.kinetic_energy(), 1.05 * most) << firmness << ' ' << damping << ' ' << ms;
      }
      EXPECT_LT(body.kinetic_energy(), 0.1 * most);
    }
  EXPECT_THROW(SoftBody({.firmness = 100.0, .damping = 0.1}), std::invalid_argument);
  EXPECT_THROW(SoftBody({.firmness = std::nan(""), .damping = 0.1}), std::invalid_argument);
}

scene::SceneDescription scene_on(const rig::Rig& rig) {
  const scene::ApplicationRegistry registry{jelly::specification()};
  auto scene = registry.describe("jelly", scene::SettingValues(jelly::setting_schema()));
  return server::physics::scene_from_rig(rig, *scene);
}

struct Law {
  sim::Simulator world{sim::config::reference_world(), 1};
  scene::SceneDescription scene = scene_on(sim::truth_rig(world));
  Pose<World, jelly::JellyFrame> X_world_jelly = jelly::place_on_table(scene);
  jelly::JellyApplication application{scene};

  scene::TipState tip(const Vector3& in_jelly) const {
    scene::TipState tip;
    tip.X_world_tip.translation = (X_world_jelly * Point<jelly::JellyFrame>{in_jelly}).m;
    return tip;
  }
  Vector3 force(const Vector3& in_jelly) {
    return X_world_jelly.rotation.conjugate() * application.contact_law()->force(tip(in_jelly), 1e-3);
  }
};

TEST(JellyLaw, BeginsAtTheSurfaceWithoutAJumpGrowsWithDepthAndIsBounded) {
  Law law;
  double before = 0.0;
  int felt = 0;
  for (double y = 0.070; y > 0.001; y -= 0.0001) {
    const Vector3 force = law.force({0.0, y, 0.0});
    EXPECT_GE(force.y(), before - 1e-9) << y;
    EXPECT_LE(force.y() - before, 0.3) << y << ": 3 N/ms at 10 cm/s would be felt as a step";
    EXPECT_LE(force.norm(), law.application.contact_law()->force_bound());
    before = force.y();
    felt += force.norm() > 0.0;
  }
  EXPECT_GT(felt, 400);
  EXPECT_GT(before, 5.0);
}

TEST(JellyLaw, FeelsNothingWhereTheTipWasPutInsideUntilItHasBeenOutside) {
  Law law;
  EXPECT_EQ(law.force({0.0, 0.030, 0.0}), Vector3::Zero());
  EXPECT_EQ(law.force({0.0, 0.029, 0.0}), Vector3::Zero());
  law.force({0.0, 0.060, 0.0});
  EXPECT_GT(law.force({0.0, 0.048, 0.0}).norm(), 0.0);
  EXPECT_EQ(law.force({0.0, 0.048, 0.2}), Vector3::Zero());
  EXPECT_EQ(law.force({0.0, 0.030, 0.0}), Vector3::Zero()) << "put there, not moved";
}

TEST(JellyLaw, NeitherItNorTheStepAllocates) {
  Law law;
  scene::SceneState state;
  law.force({0.0, 0.06, 0.0});
  law.application.step(Instant<PhysicsClock>{}, std::chrono::milliseconds(1), law.tip({0.0, 0.06, 0.0}),
                       state);
  const std::size_t before = allocations();
  for (int ms = 0; ms < 100; ++ms) {
    const Vector3 place(0.0, 0.06 - 1e-4 * ms, 0.001);
    law.force(place);
    law.application.step(Instant<PhysicsClock>{}, std::chrono::milliseconds(1), law.tip(place), state);
  }
  EXPECT_EQ(allocations() - before, 0u);
  EXPECT_GT(state.counters[jelly::kForceMn], 100);
}

// Draws each frame as the graphics server does, and the most dented one once more as if nothing had deformed.
class Watched : public server::graphics::FramePipeline {
 public:
  Watched(const rig::Rig& rig, const scene::SceneDescription& scene, std::unique_ptr<scene::SceneView> view)
      : pictures_(rig, scene, std::move(view), render::Quality::low) {}
  bool sees() const override { return pictures_.sees(); }
  void refine(server::graphics::EyeSide side, const device::CameraImage& image, const Matrix6& covariance,
              server::graphics::EyePose& pose) override {
    pictures_.refine(side, image, covariance, pose);
  }
  Expected<void> find(const device::CameraImage& image, const std::optional<Pose<World, CameraOptical>>& near,
                      server::graphics::FrameRecord& record) override {
    return pictures_.find(image, near, record);
  }
  scene::SceneState predict(const scene::SceneState& state, Duration ahead) override {
    return pictures_.predict(state, ahead);
  }
  void draw(const device::CameraImage& image, const device::CameraImage* right,
            server::graphics::FrameRecord& record) override {
    const int dent = record.have_state && record.shape ? record.state.counters[jelly::kDentUm] : 0;
    if (dent > deepest) {
      deepest = dent;
      rest = record;
      rest.shape.reset();
      pictures_.draw(image, right, rest);
      pictures_.draw(image, right, record);
      dented = record;
      return;
    }
    pictures_.draw(image, right, record);
  }
  int deepest = 2000;  // um; less is no dent to look at
  server::graphics::FrameRecord dented, rest;

 private:
  server::graphics::FrameRenderer pictures_;
};

double deepest_of(const scene::Shape& shape, const Pose<World, jelly::JellyFrame>& X_world_jelly) {
  static const auto mould = jelly::mould();
  double deepest = 0.0;
  for (std::size_t i = 0; i < jelly::kVertices; ++i) {
    const Vector3 at(shape.values[6 * i], shape.values[6 * i + 1], shape.values[6 * i + 2]);
    const Vector3 in_jelly = (X_world_jelly.inverse() * Point<World>{at}).m;
    deepest = std::max(deepest, -facing()[i].dot(in_jelly - mould.vertices[i]));
  }
  return deepest;
}

TEST(AnApplicationFromOutside, PlaysThroughTheExchangeWithItsDeformingSurfaceInThePicture) {
  sim::CameraRenderer renderer;
  sim::Simulator world(sim::config::reference_world(), 3);
  const rig::Rig rig = sim::truth_rig(world);
  const auto scene = scene_on(rig);
  const auto X_world_jelly = jelly::place_on_table(scene);
  sim::lockstep::LockstepOptions options;
  options.applications = {jelly::specification()};
  options.seconds = 4.0;
  options.seed = 3;
  std::map<std::int64_t, std::int32_t> dents;  // by the time of the state, um
  options.watch = [&](const scene::SceneState& state) {
    dents[state.time.ns()] = state.counters[jelly::kDentUm];
  };
  auto view = options.applications.make_view(scene);
  ASSERT_TRUE(view);
  Watched watched(rig, scene, std::move(*view));
  sim::lockstep::LockstepPictures pictures;
  pictures.camera = [&](const sim::TrueView& seen, std::vector<std::uint8_t>& rgb) {
    renderer.render(seen, rgb);
  };
  pictures.pipeline = &watched;
  std::size_t compared = 0;
  pictures.shown = [&](const server::graphics::FrameRecord& frame) {
    if (!frame.shape || !frame.have_state) return;
    ASSERT_EQ(frame.shape->vertices(), jelly::kVertices);
    // The shape is of the moment that the picture shows.
    EXPECT_LE(std::abs((frame.shape->time - frame.state.time).count()), 1'000'000)
        << "ns, a tick of the physics loop";
    // And it is that of the physics side then: as deep as between the two shapes of the history around that moment.
    constexpr auto kApart = static_cast<std::int64_t>(1e9 / scene::ShapeHistory::kRateHz) + 1'000'000;
    const auto from = dents.lower_bound(frame.shape->time.ns() - kApart);
    const auto to = dents.upper_bound(frame.shape->time.ns() + kApart);
    if (from == dents.begin() || to == dents.end()) return;
    double low = from->second, high = low;
    for (auto at = from; at != to; ++at) {
      low = std::min<double>(low, at->second);
      high = std::max<double>(high, at->second);
    }
    const double deepest = 1e6 * deepest_of(*frame.shape, X_world_jelly);
    EXPECT_GE(deepest, low - 20.0) << "um";
    EXPECT_LE(deepest, high + 20.0) << "um; a picture late it is hundreds off";
    ++compared;
  };
  const auto play = sim::lockstep::play_in_lockstep(world, rig, scene, options, pictures, {});
  ASSERT_TRUE(play) << play.error().message;
  EXPECT_GT(compared, 20u);
  EXPECT_GT(play->haptic.peak_n, 0.5);
  EXPECT_EQ(play->haptic.fault_ticks, 0u);
  EXPECT_GE(play->final_state.counters[jelly::kPresses], 1);

  // Pixels: what differs from the picture of the jelly at rest lies on the jelly, and is not little.
  const auto &dented = watched.dented, &rest = watched.rest;
  ASSERT_GT(watched.deepest, 3000) << "um";
  ASSERT_EQ(dented.rgb.size(), rest.rgb.size());
  ASSERT_FALSE(dented.rgb.empty());
  const auto centre = rig.camera->model.project(
      (dented.X_world_camera.inverse() * Point<World>{X_world_jelly.translation + 0.5 * kTop}).m);
  int near = 0, far = 0;
  for (int v = 0; v < dented.height; ++v)
    for (int u = 0; u < dented.width; ++u) {
      const auto at = 3 * (static_cast<std::size_t>(v) * static_cast<std::size_t>(dented.width) +
                           static_cast<std::size_t>(u));
      int most = 0;
      for (std::size_t k = 0; k < 3; ++k)
        most = std::max(most, std::abs(dented.rgb[at + k] - rest.rgb[at + k]));
      if (most <= 16) continue;
      (std::hypot(u - centre.x(), v - centre.y()) < 90.0 ? near : far)++;
    }
  EXPECT_GT(near, 150) << "pixels of the dent and of what bulges";
  EXPECT_EQ(far, 0);
}

}  // namespace
}  // namespace palpate
