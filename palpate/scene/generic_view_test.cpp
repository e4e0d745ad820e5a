#include "palpate/scene/generic_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace palpate::scene {
namespace {

SceneState three_bodies() {
  SceneState state;
  state.body_count = 3;
  state.bodies[0].set_p({1, 2, 3});
  state.bodies[1].visible = 0;
  state.bodies[2].set_p({-0.1, 0.2, 0.3});
  state.bodies[2].set_q(so3_exp(Vector3(0.3, -1.1, 0.4)));
  return state;
}

TEST(GenericView, ShowsEachVisibleBodyAsASphereOfItsRadius) {
  const double radius = 0.035;
  const GenericView view("unheard-of", 0, radius);
  const auto state = three_bodies();
  std::vector<DrawItem> spheres;
  for (const auto& item : view.draw(state))
    if (item.sphere_radius) spheres.push_back(item);
  ASSERT_EQ(spheres.size(), 2u);
  EXPECT_EQ(spheres[0].position, state.bodies[0].p());
  EXPECT_EQ(spheres[1].position, state.bodies[2].p());
  for (const auto& item : spheres) {
    EXPECT_EQ(*item.sphere_radius, radius);
    for (const auto& v : item.mesh->vertices) EXPECT_NEAR(v.norm(), radius, 1e-12);
    EXPECT_TRUE(item.casts_shadow);
    EXPECT_EQ(item.look.colour[0], item.look.colour[1]);  // grey: it stands for no particular thing
    EXPECT_EQ(item.look.colour[1], item.look.colour[2]);
  }
}

// What sticks out of a sphere, and where to, tells the body's three axes and their directions.
TEST(GenericView, ShowsHowABodyIsTurnedByAPinAlongEachAxis) {
  const double radius = 0.035;
  const GenericView view("unheard-of", 0, radius);
  const auto state = three_bodies();
  for (const std::size_t body : {0u, 2u}) {
    std::array<int, 3> pins{};
    for (const auto& item : view.draw(state)) {
      if (item.sphere_radius || item.position != state.bodies[body].p()) continue;
      Vector3 middle = Vector3::Zero(), farthest = Vector3::Zero();
      for (const auto& v : item.mesh->vertices) {
        middle += item.rotation * v / static_cast<double>(item.mesh->vertices.size());
        if (v.norm() > farthest.norm()) farthest = v;
      }
      EXPECT_GT(farthest.norm(), 1.4 * radius);
      const auto& colour = item.look.colour;  // red, green, blue: x, y, z
      const auto axis = static_cast<int>(std::max_element(colour.begin(), colour.end()) - colour.begin());
      ++pins[static_cast<std::size_t>(axis)];
      EXPECT_GT(middle.normalized().dot(state.bodies[body].q() * Vector3::Unit(axis)), 1.0 - 1e-12);
    }
    EXPECT_EQ(pins, (std::array<int, 3>{1, 1, 1})) << body;
  }
}

TEST(GenericView, ShowsNoMoreBodiesThanAStateHas) {
  const GenericView view("unheard-of");
  EXPECT_TRUE(view.draw(SceneState{}).empty());
  SceneState state;
  state.body_count = std::numeric_limits<std::int32_t>::max();
  EXPECT_EQ(view.draw(state).size(), 4u * SceneState::kBodies);
  state.body_count = -1;
  EXPECT_TRUE(view.draw(state).empty());
}

TEST(GenericView, ShowsTheVerticesOfASurfaceThatDeforms) {
  const GenericView view("unheard-of", 12);
  const auto items = view.draw(SceneState{});
  ASSERT_EQ(items.size(), 1u);
  EXPECT_TRUE(items[0].deforms);
  EXPECT_EQ(items[0].mesh->vertices.size(), 12u);
  EXPECT_TRUE(items[0].mesh->triangles.empty());
}

TEST(GenericView, SaysThatTheApplicationIsNotThere) {
  const std::vector<std::string> said{"application 'juggling' is not part of this program:",
                                      "its bodies are shown as plain shapes"};
  EXPECT_EQ(GenericView("juggling").captions({}), said);
  // A name comes over the network: it may be anything.
  const auto lines = GenericView("a\nb" + std::string(500, 'c')).captions({});
  EXPECT_EQ(lines[0].find('\n'), std::string::npos);
  EXPECT_LT(lines[0].size(), 80u);
}

TEST(GenericView, RefusesARadiusThatIsNone) {
  for (const double radius :
       {0.0, -0.01, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(GenericView("juggling", 0, radius), std::invalid_argument) << radius;
}

}  // namespace
}  // namespace palpate::scene
