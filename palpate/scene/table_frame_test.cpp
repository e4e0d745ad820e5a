#include "palpate/scene/table_frame.h"

#include <gtest/gtest.h>

namespace palpate::scene {
namespace {

TEST(TableFrame, IsRightUpAndTowardsThePersonFromTheMiddleOfTheNearEdge) {
  SceneDescription scene;
  const Quaternion turned(Eigen::AngleAxisd(0.4, Vector3(0.3, 1.0, -0.2).normalized()));
  const Vector3 middle(0.1, -0.2, 0.3);
  const auto corner = [&](double x, double z) { return Vector3(middle + turned * Vector3(x, 0.0, z)); };
  scene.surfaces = {{"wall", {}},
                    {"table", {corner(-0.5, 0.0), corner(0.5, 0.0), corner(0.5, -0.7), corner(-0.5, -0.7)}}};
  const TableFrame table = table_frame(scene);
  EXPECT_LT((table.edge - middle).norm(), 1e-12);
  EXPECT_LT((table.right - turned * Vector3::UnitX()).norm(), 1e-12);
  EXPECT_LT((table.up - turned * Vector3::UnitY()).norm(), 1e-12);
  EXPECT_LT((table.near - turned * Vector3::UnitZ()).norm(), 1e-12);
  EXPECT_LT(table.rotation.angularDistance(turned), 1e-7);
}

TEST(TableFrame, OfASceneWithoutATableIsRefusedWithTheRemedy) {
  SceneDescription scene;
  scene.surfaces = {{"wall", {}}};
  try {
    table_frame(scene);
    FAIL();
  } catch (const std::invalid_argument& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("palpate calibrate surface"), std::string::npos);
  }
}

}  // namespace
}  // namespace palpate::scene
