#include "palpate/scene/mesh_asset.h"

#include <gtest/gtest.h>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::scene {
namespace {

// A tetrahedron whose box has these sides in the file's unit.
std::string tetrahedron(const std::string& x, const std::string& y, const std::string& z) {
  return "v 0 0 0\nv " + x + " 0 0\nv 0 " + y + " 0\nv 0 0 " + z + "\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
}

class MeshAssets : public testing::Test {
 protected:
  std::filesystem::path file(const std::string& name, const std::string& content) {
    EXPECT_TRUE(write_file(folder_ / name, content));
    return folder_ / name;
  }
  static SceneDescription scene_with(const std::filesystem::path& file, double metres_per_unit = 0.001) {
    SceneDescription scene;
    scene.mesh = MeshAsset{.file = file.string(), .metres_per_unit = metres_per_unit};
    return scene;
  }
  // As it arrives over the network.
  static SceneDescription sent(SceneDescription scene) {
    scene.mesh->mesh = nullptr;
    return scene;
  }

  ScratchFolder folder_;
};

TEST_F(MeshAssets, IsReadOnOneSideAndFoundOnTheOther) {
  auto scene = scene_with(file("t.obj", tetrahedron("60", "40", "50")));
  const auto line = read_mesh_asset(scene);
  ASSERT_TRUE(line) << line.error().message;
  EXPECT_NE(line->find("4 triangles, 60 x 40 x 50 mm; 1 part, closed"), std::string::npos) << *line;
  ASSERT_NE(scene.mesh->mesh, nullptr);
  EXPECT_FALSE(scene.mesh->hash.empty());
  auto here = sent(scene);
  ASSERT_TRUE(find_mesh_asset(here, {}, true));
  EXPECT_EQ(here.mesh->mesh->vertices, scene.mesh->mesh->vertices);
  // On another machine it has to be named; a copy will do.
  auto there = sent(scene);
  EXPECT_NE(find_mesh_asset(there, {}, false).error().message.find("--mesh FILE"), std::string::npos);
  EXPECT_TRUE(find_mesh_asset(there, file("copy.obj", tetrahedron("60", "40", "50")), false));
  EXPECT_NE(there.mesh->mesh, nullptr);
  auto other = sent(scene);
  const auto changed = find_mesh_asset(other, file("other.obj", tetrahedron("60", "40", "51")), true);
  ASSERT_FALSE(changed);
  EXPECT_EQ(changed.error().kind, Error::Kind::refused);
  EXPECT_NE(changed.error().message.find("is not the mesh that the physics server uses"), std::string::npos);
  EXPECT_EQ(other.mesh->mesh, nullptr);
}

TEST_F(MeshAssets, WithoutAFileThereIsNothingToRead) {
  SceneDescription none;
  EXPECT_EQ(*read_mesh_asset(none), "");
  EXPECT_TRUE(find_mesh_asset(none, {}, false));
  SceneDescription made;  // a mesh that came from no file
  made.mesh = MeshAsset{.mesh = std::make_shared<TriangleMesh>()};
  EXPECT_EQ(*read_mesh_asset(made), "");
  EXPECT_TRUE(find_mesh_asset(made, {}, false));
}

TEST_F(MeshAssets, WhatNoHandExploresIsRefusedWithTheRemedy) {
  const auto refusal = [](SceneDescription scene) {
    const auto read = read_mesh_asset(scene);
    return read ? std::string() : read.error().message;
  };
  const auto path = file("t.obj", tetrahedron("60", "40", "50"));
  EXPECT_NE(
      refusal(scene_with(path, 1.0)).find("60000 x 40000 x 50000 mm large; a largest side of 5 to 500 mm"),
      std::string::npos);
  EXPECT_NE(refusal(scene_with(path, 1e-6)).find("check the unit"), std::string::npos);
  EXPECT_NE(refusal(scene_with(folder_ / "missing.stl")).find("missing.stl"), std::string::npos);
  EXPECT_NE(refusal(scene_with(file("words.obj", "no mesh at all"))).find("is no mesh"), std::string::npos);
  EXPECT_NE(refusal(scene_with("/" + std::string(600, 'd'))).find("601 bytes, at most 512"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate::scene
