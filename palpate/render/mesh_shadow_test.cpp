// Whose shadow is whose shape, and what follows a mesh whose vertices move: beside rays, and beside a
// compositor that has never seen the mesh before.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "tests/picture_scene_for_tests.h"

namespace palpate::render {
namespace {

constexpr std::uint8_t kLevel = 150;

// A lamp so small that its shadows have edges of a millimetre or two.
CompositorSettings small_lamp() {
  CompositorSettings settings;
  settings.light.lamp_radius = 0.005;
  return settings;
}

std::vector<std::uint8_t> picture_of(Compositor& compositor, const scene::DrawItem& item,
                                     const RealScene& real = real_scene(false)) {
  std::vector<std::uint8_t> rgb;
  compositor.draw(even_image(kTestCamera, kLevel), kTestCamera, kTestEye, {&item, 1}, real, rgb);
  return rgb;
}

bool hits(const Triangles& shape, const Vector3& from, const Vector3& to) {
  return nearest_hit(shape, from, to - from) < 1.0;
}

struct TablePlace {
  Vector3 at;
  bool shaded = false;
};

// Places of the table round `middle` that the eye sees past `shape`, and whether the lamp sees them. Places
// within 4 mm of the shadow's edge or within 2 px of the body's outline are left out.
std::vector<TablePlace> table_places(const Triangles& shape, const Vector3& lamp, const Vector3& middle) {
  std::vector<TablePlace> places;
  const Vector3 eye = kTestEye.translation;
  for (double x = -0.2; x <= 0.2; x += 0.004)
    for (double z = -0.2; z <= 0.2; z += 0.004) {
      const Vector3 p(middle.x() + x, kTableHeight, middle.z() + z);
      const bool shaded = hits(shape, p, lamp);
      bool edge = false;
      for (const auto& [a, b] : {std::pair{4e-3, 0.0}, {-4e-3, 0.0}, {0.0, 4e-3}, {0.0, -4e-3}}) {
        const Vector3 beside = p + Vector3(a, 0.0, b);
        edge = edge || hits(shape, beside, lamp) != shaded || hits(shape, eye, beside);
      }
      if (!edge && !hits(shape, eye, p)) places.push_back({p, shaded});
    }
  return places;
}

bool dark(const std::vector<std::uint8_t>& rgb, const Vector3& p) {
  const device::Pixel at = kTestCamera.project_undistorted((kTestEye.inverse() * Point<World>{p}).m);
  // Without the lamp 0.55 of the byte is left, half way it is 0.8.
  return pixel_of(rgb, kTestCamera, static_cast<int>(std::lround(at.x())),
                  static_cast<int>(std::lround(at.y())))[1] < 0.8 * kLevel;
}

const Vector3 kOverTable{-0.02, kTableHeight + 0.12, 1.40};
Vector3 foot_of(const Vector3& p, const Vector3& lamp) {
  return lamp + (p - lamp) * ((lamp.y() - kTableHeight) / (lamp.y() - p.y()));
}

// Its bounding box is a ball's.
TEST(MeshShadow, OfACubeHasTheCubesCorners) {
  const CompositorSettings settings = small_lamp();
  const double half = 0.04;
  const scene::TriangleMesh cube = scene::box_mesh({-half, -half, -half}, {half, half, half});
  Compositor compositor(settings);
  const Vector3 lamp = settings.light.lamp;
  for (const double turn : {0.0, 0.7}) {
    scene::DrawItem item = item_at(cube, kOverTable);
    item.rotation = so3_exp(Vector3(0.0, turn, 0.0));
    const auto rgb = picture_of(compositor, item);
    scene::DrawItem taken_for_a_ball = item;
    taken_for_a_ball.sphere_radius = half;
    const auto round = picture_of(compositor, taken_for_a_ball);
    int wrong = 0, shaded = 0, lit = 0, corners = 0;
    for (const TablePlace& place :
         table_places(triangles_of(cube, item.rotation, item.position), lamp, foot_of(kOverTable, lamp))) {
      wrong += dark(rgb, place.at) != place.shaded;
      (place.shaded ? shaded : lit) += 1;
      corners += place.shaded && !dark(round, place.at);
    }
    EXPECT_EQ(wrong, 0) << "of " << shaded << " and " << lit;
    EXPECT_GT(shaded, 200);
    EXPECT_GT(lit, 1000);
    EXPECT_GT(corners, 50);  // that the shadow of a ball in the same box lacks
  }
}

TEST(MeshShadow, OfASphereIsRoundWhetherItSaysSoOrNot) {
  const CompositorSettings settings = small_lamp();
  const double radius = 0.03;
  const scene::TriangleMesh mesh = scene::sphere_mesh(radius, 48, 96);
  Compositor compositor(settings);
  const Vector3 lamp = settings.light.lamp;
  const auto places =
      table_places(triangles_of(mesh, Quaternion::Identity(), kOverTable), lamp, foot_of(kOverTable, lamp));
  const auto exact = picture_of(compositor, sphere_at(mesh, radius, kOverTable)),
             triangles = picture_of(compositor, item_at(mesh, kOverTable));
  int shaded = 0;
  for (const TablePlace& place : places) {
    EXPECT_EQ(dark(exact, place.at), place.shaded) << place.at.transpose();
    EXPECT_EQ(dark(triangles, place.at), place.shaded) << place.at.transpose();
    shaded += place.shaded;
  }
  EXPECT_GT(shaded, 100);
}

scene::TriangleMesh level_sheet(double half) {
  constexpr std::uint32_t kAcross = 9;
  scene::TriangleMesh mesh;
  for (std::uint32_t i = 0; i < kAcross; ++i)
    for (std::uint32_t k = 0; k < kAcross; ++k)
      mesh.vertices.emplace_back(half * (i / 4.0 - 1.0), 0.0, half * (k / 4.0 - 1.0));
  for (std::uint32_t i = 0; i + 1 < kAcross; ++i)
    for (std::uint32_t k = 0; k + 1 < kAcross; ++k) {
      const std::uint32_t a = kAcross * i + k, b = a + kAcross;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  return mesh;
}

// The lamp stands at the right: the sheet turns away from it and becomes longer.
void deform(scene::TriangleMesh& mesh) {
  for (Vector3& v : mesh.vertices) v = Vector3(1.2 * v.x(), 1.0 * v.x(), v.z());
}

TEST(DeformingMesh, ChangesPictureShadingAndShadowWithItsVersionAndNotBefore) {
  const CompositorSettings settings = small_lamp();
  const Vector3 lamp = settings.light.lamp;
  scene::TriangleMesh sheet = level_sheet(0.05);
  const scene::DrawItem item = item_at(sheet, kOverTable);
  Compositor compositor(settings);
  const auto level = picture_of(compositor, item);
  deform(sheet);
  EXPECT_EQ(picture_of(compositor, item), level);
  sheet.version.raise();
  const auto tilted = picture_of(compositor, item);
  ASSERT_NE(tilted, level);
  Compositor fresh(settings);
  EXPECT_EQ(tilted, picture_of(fresh, item));

  // Shading: in the middle, which has stayed where it is, the sheet now takes less of the lamp's light. By
  // how much says Lambert's law; the room's light and the lamp's image move the ratio by less than a tenth.
  const device::Pixel middle =
      kTestCamera.project_undistorted((kTestEye.inverse() * Point<World>{kOverTable}).m);
  const auto red = [&](const std::vector<std::uint8_t>& rgb) {
    return pixel_of(rgb, kTestCamera, static_cast<int>(std::lround(middle.x())),
                    static_cast<int>(std::lround(middle.y())))[0];
  };
  const Vector3 to_lamp = (lamp - kOverTable).normalized();
  const auto lit = [&](const Vector3& n) {
    return settings.light.ambient * (0.75 + 0.25 * n.y()) +
           settings.light.key * std::max(0.0, n.dot(to_lamp));
  };
  const double expected = std::sqrt(lit(Vector3(-1.0, 1.2, 0.0).normalized()) / lit(Vector3::UnitY()));
  EXPECT_LT(expected, 0.9);
  EXPECT_NEAR(static_cast<double>(red(tilted)) / red(level), expected, 0.1);

  int wrong = 0, newly_dark = 0;
  for (const TablePlace& place :
       table_places(triangles_of(sheet, item.rotation, item.position), lamp, foot_of(kOverTable, lamp))) {
    wrong += dark(tilted, place.at) != place.shaded;
    newly_dark += place.shaded && !dark(level, place.at);
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(newly_dark, 20);
}

// The sheet as a physics server sends it: where its vertices are in World, and the normal of all of them.
std::shared_ptr<const scene::Shape> shape_of(const scene::TriangleMesh& sheet, const Vector3& place,
                                             const Vector3& normal) {
  auto shape = std::make_shared<scene::Shape>();
  for (const Vector3& v : sheet.vertices)
    for (const Vector3& one : {Vector3(place + v), normal})
      for (int i = 0; i < 3; ++i) shape->values.push_back(static_cast<float>(one[i]));
  return shape;
}

int pixels_that_differ(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  int count = 0;
  for (std::size_t i = 0; i < a.size(); i += 3)
    count +=
        std::abs(a[i] - b[i]) > 1 || std::abs(a[i + 1] - b[i + 1]) > 1 || std::abs(a[i + 2] - b[i + 2]) > 1;
  return count;
}

TEST(DeformingSurface, IsDrawnShadedAndThrowsItsShadowAsItsShapeSays) {
  const CompositorSettings settings = small_lamp();
  scene::TriangleMesh sheet = level_sheet(0.05);
  const Vector3 tilted_normal = Vector3(-1.0, 1.2, 0.0).normalized();
  scene::DrawItem item = item_at(sheet, kOverTable);
  item.deforms = true;
  Compositor compositor(settings);
  const auto level = picture_of(compositor, item);
  EXPECT_EQ(picture_of(compositor, item_at(sheet, kOverTable)), level) << "no shape has come yet";

  scene::TriangleMesh moved = sheet;
  deform(moved);
  const auto tilted = picture_of(compositor, item_at(moved, kOverTable));
  item.shape = shape_of(moved, kOverTable, tilted_normal);
  // Its own place no longer counts: a shape is in World.
  item.position = Vector3(1.0, 2.0, 3.0);
  EXPECT_GT(pixels_that_differ(level, tilted), 500);
  const auto shown = picture_of(compositor, item);
  EXPECT_LE(pixels_that_differ(shown, tilted), 5);  // World in floats, at the edges

  // The next shape, of which only the normals are new: shaded anew, the shadow stays.
  item.shape = shape_of(moved, kOverTable, Vector3::UnitY());
  const auto lighter = picture_of(compositor, item);
  const Vector3 lamp = settings.light.lamp;
  const auto places =
      table_places(triangles_of(moved, Quaternion::Identity(), kOverTable), lamp, foot_of(kOverTable, lamp));
  for (const TablePlace& place : places) {
    EXPECT_EQ(dark(shown, place.at), place.shaded) << place.at.transpose();
    EXPECT_EQ(dark(lighter, place.at), place.shaded) << place.at.transpose();
  }
  EXPECT_GT(pixels_that_differ(shown, lighter), 200);

  // And back to the first: what is on the card is not taken for it.
  item.shape = shape_of(moved, kOverTable, tilted_normal);
  EXPECT_EQ(picture_of(compositor, item), shown);
}

TEST(DeformingSurface, OfAnotherNumberOfVerticesIsDrawnAtRest) {
  scene::TriangleMesh sheet = level_sheet(0.05);
  scene::DrawItem item = item_at(sheet, kOverTable);
  Compositor compositor(small_lamp());
  const auto level = picture_of(compositor, item);
  auto shape = std::make_shared<scene::Shape>(*shape_of(sheet, kOverTable, Vector3::UnitX()));
  shape->values.resize(shape->values.size() - scene::Shape::kFloatsPerVertex);
  item.shape = shape;
  EXPECT_EQ(picture_of(compositor, item), level);
}

// As a client shows it that does not have the application: where its triangles cover a pixel, so do its vertices.
TEST(DeformingSurface, WithoutItsTrianglesIsStillShownAsASurface) {
  scene::TriangleMesh sheet = level_sheet(0.05);
  scene::TriangleMesh moved = sheet;
  deform(moved);
  const Vector3 normal = Vector3(-1.0, 1.2, 0.0).normalized();
  Compositor compositor(small_lamp());
  const auto bare = even_image(kTestCamera, kLevel).rgb;
  scene::DrawItem item = item_at(sheet, kOverTable);
  item.casts_shadow = false;
  item.shape = shape_of(moved, kOverTable, normal);
  const auto known = picture_of(compositor, item);
  scene::TriangleMesh points;
  points.vertices = sheet.vertices;
  item.mesh = &points;
  const auto unknown = picture_of(compositor, item);
  int surface = 0, gaps = 0;
  for (std::size_t i = 0; i < bare.size(); i += 3) {
    if (std::abs(known[i] - bare[i]) < 3) continue;
    ++surface;
    gaps += 2 * std::abs(unknown[i] - bare[i]) < std::abs(known[i] - bare[i]);
  }
  EXPECT_GT(surface, 500);
  EXPECT_LT(gaps, surface / 20);
  item.shape = nullptr;
  EXPECT_EQ(picture_of(compositor, item), bare) << "nothing has come yet";
}

TEST(DeformingMesh, ThatIsRealHidesWhatIsBehindItNow) {
  scene::TriangleMesh block = scene::box_mesh({-0.05, 0.0, -0.05}, {0.05, 0.1, 0.05});
  RealScene real = real_scene(false);
  const Vector3 place(0.0, kTableHeight, 1.4), middle = place + Vector3(0.0, 0.05, 0.0);
  real.bodies.push_back({&block, Quaternion::Identity(), place});
  CompositorSettings settings;
  settings.shadows = false;
  Compositor compositor(settings);
  const scene::TriangleMesh ball = scene::sphere_mesh(0.020);
  const Vector3 away = (middle - kTestEye.translation).normalized();
  const scene::DrawItem behind = sphere_at(ball, 0.020, middle + 0.10 * away);
  const auto hidden = picture_of(compositor, behind, real);
  EXPECT_EQ(hidden, even_image(kTestCamera, kLevel).rgb);
  for (Vector3& v : block.vertices) v.y() *= 0.1;
  block.version.raise();
  EXPECT_NE(picture_of(compositor, behind, real), hidden);
}

// Triangles that are taken away open a body: its inside is then seen, and its far side throws a shadow.
TEST(DeformingMesh, MayLoseTriangles) {
  scene::TriangleMesh box = scene::box_mesh({-0.04, -0.04, -0.04}, {0.04, 0.04, 0.04});
  const scene::DrawItem item = item_at(box, kOverTable);
  const CompositorSettings settings = small_lamp();
  Compositor compositor(settings), fresh(settings);
  const auto closed = picture_of(compositor, item);
  std::erase_if(box.triangles, [&](const auto& t) {
    return box.vertices[t[0]].y() > 0 && box.vertices[t[1]].y() > 0 && box.vertices[t[2]].y() > 0;
  });
  box.version.raise();
  ASSERT_EQ(box.triangles.size(), 10u);
  const auto open = picture_of(compositor, item);
  EXPECT_NE(open, closed);
  EXPECT_EQ(open, picture_of(fresh, item));
}

// Another mesh may come to lie at the same address.
TEST(DeformingMesh, IsNotTakenForOneThatWasThereBefore) {
  Compositor compositor(small_lamp()), fresh(small_lamp());
  std::optional<scene::TriangleMesh> place(std::in_place,
                                           scene::box_mesh({-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02}));
  const scene::DrawItem item = item_at(*place, kOverTable);
  const auto box = picture_of(compositor, item);
  const scene::TriangleMesh other = scene::sphere_mesh(0.02);
  place.reset();
  place.emplace(other);
  ASSERT_EQ(item.mesh, &*place);
  const auto ball = picture_of(compositor, item);
  EXPECT_NE(ball, box);
  EXPECT_EQ(ball, picture_of(fresh, item));
}

// Fewer triangles throw the shadow of all, to less than a cell: rays at a coarser ball of the same size tell.
TEST(MeshShadow, OfManyTrianglesIsThrownByFewer) {
  CompositorSettings settings = small_lamp();
  settings.shadow_cells = 40;
  Compositor compositor(settings);
  const scene::TriangleMesh fine = scene::sphere_mesh(0.05, 80, 160), plain = scene::sphere_mesh(0.05);
  const scene::DrawItem item = item_at(fine, kOverTable);
  const auto rgb = picture_of(compositor, item);
  int wrong = 0, shaded = 0;
  for (const TablePlace& place :
       table_places(triangles_of(plain, item.rotation, item.position), settings.light.lamp,
                    foot_of(kOverTable, settings.light.lamp))) {
    wrong += dark(rgb, place.at) != place.shaded;
    shaded += place.shaded;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(shaded, 100);
}

TEST(MeshShadow, FewerTrianglesOfAClosedSurfaceStillCloseIt) {
  const ShadedMesh fine = shaded(scene::sphere_mesh(0.05, 80, 160));
  const auto fewer = clustered(fine, 40);
  EXPECT_LT(fewer.size(), fine.indices.size() / 4);
  EXPECT_GT(fewer.size(), fine.indices.size() / 40);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> open;  // edges walked one way, less the other
  for (std::size_t t = 0; t < fewer.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = fewer[t + k], b = fewer[t + (k + 1) % 3];
      open[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  for (const auto& [edge, count] : open) EXPECT_EQ(count, 0) << edge.first << " " << edge.second;
  EXPECT_EQ(clustered(fine, 0), fine.indices);
  EXPECT_TRUE(clustered({}, 40).empty());
}

}  // namespace
}  // namespace palpate::render
