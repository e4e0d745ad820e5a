#include "palpate/server/graphics/real_objects.h"

#include <gtest/gtest.h>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::server::graphics {
namespace {

TEST(RealObjects, ComeFromBesideTheRigFileInItsUnit) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file(folder.path() / "wedge.obj",
                         "v 0 0 0\nv 100 0 0\nv 0 50 0\nv 0 0 20\n"
                         "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"));
  const auto rig_path = folder.path() / "rig.toml";
  rig::Rig rig;
  rig.objects.push_back({"wedge", "wedge.obj", 0.001, Quaternion::Identity(), {0.1, -1.5, 1.2}});
  ASSERT_TRUE(rig::write_rig(rig_path, rig));
  const auto again = rig::read_rig(rig_path);
  ASSERT_TRUE(again) << again.error().message;
  const auto objects = RealObjects::read(*again);
  ASSERT_TRUE(objects) << objects.error().message;
  const auto bodies = objects->bodies();
  ASSERT_EQ(bodies.size(), 1u);
  EXPECT_EQ(bodies[0].mesh->triangles.size(), 4u);
  double longest = 0.0;
  for (const Vector3& v : bodies[0].mesh->vertices) longest = std::max(longest, v.norm());
  EXPECT_NEAR(longest, 0.1, 1e-12);
  EXPECT_EQ(bodies[0].position, Vector3(0.1, -1.5, 1.2));
}

TEST(RealObjects, ThatHaveNoMeshAreNamed) {
  rig::Rig rig;
  rig.objects.push_back({"head", "nowhere.stl", 0.001, Quaternion::Identity(), Vector3::Zero()});
  const auto objects = RealObjects::read(rig);
  ASSERT_FALSE(objects);
  EXPECT_EQ(objects.error().exit_code(), 2);
  EXPECT_NE(objects.error().message.find("object 'head' of the rig"), std::string::npos);
  EXPECT_NE(objects.error().message.find("nowhere.stl"), std::string::npos);
}

TEST(PictureSettings, TakeLightAndEncodingFromTheRigAndTheRestFromTheQuality) {
  rig::Rig rig;
  rig.light = device::RoomLight{{0.1, 0.2, 0.3}, 0.05, 0.5, 0.6};
  rig.camera.emplace();
  rig.camera->encoding = device::Encoding::srgb;
  const auto settings = picture_settings(rig, render::Quality::low);
  EXPECT_EQ(settings.light.lamp, rig.light->lamp);
  EXPECT_EQ(settings.light.ambient, 0.6);
  EXPECT_EQ(settings.encoding, device::Encoding::srgb);
  EXPECT_EQ(settings.samples, render::settings_of(render::Quality::low).samples);
  EXPECT_EQ(picture_settings({}, render::Quality::medium).encoding, device::Encoding::root);
}

}  // namespace
}  // namespace palpate::server::graphics
