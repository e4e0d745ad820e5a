#include "applications/touched_mesh.h"

#include <fmt/format.h>

#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/scene/mesh_file.h"

namespace palpate::applications {
namespace {

constexpr std::size_t kMostPathBytes = 512;  // that the network carries

Vector3 size_of(const scene::TriangleMesh& mesh) {
  Vector3 low = mesh.vertices.front(), high = low;
  for (const auto& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return high - low;
}

Expected<scene::MeshFile> read_for_touch(const std::filesystem::path& path, double metres_per_unit) {
  auto file = scene::read_mesh(path, metres_per_unit);
  if (!file) return file;
  const Vector3 size = size_of(file->mesh);
  if (size.maxCoeff() < kSmallestTouched || size.maxCoeff() > kLargestTouched)
    return wrong_use(
        "{}: is {:g} x {:g} x {:g} mm large; a largest side of {:.0f} to {:.0f} mm is expected; check "
        "the "
        "unit (--unit, or unit in the world file) or choose a scale",
        path.string(), mm_from_metres(size.x()), mm_from_metres(size.y()), mm_from_metres(size.z()),
        mm_from_metres(kSmallestTouched), mm_from_metres(kLargestTouched));
  if (file->mesh.triangles.size() > kMostTouchedTriangles)
    return wrong_use("{}: has {} triangles; at most {} are expected, which are felt in time; simplify it",
                     path.string(), file->mesh.triangles.size(), kMostTouchedTriangles);
  return file;
}

}  // namespace

Expected<std::string> read_touched_mesh(scene::SceneDescription& scene) {
  auto& touched = scene.touched;
  if (touched.mesh_file.empty()) return std::string();
  if (scene.application != "touch")
    return wrong_use("--mesh {}: {} touches no mesh; --app touch does", touched.mesh_file, scene.application);
  if (touched.mesh_file.size() > kMostPathBytes)
    return wrong_use("{}: the path has {} bytes, at most {} are expected; put the file elsewhere",
                     excerpt(touched.mesh_file), touched.mesh_file.size(), kMostPathBytes);
  auto file = read_for_touch(touched.mesh_file, touched.metres_per_unit);
  if (!file) return tl::unexpected(file.error());
  const Vector3 size = size_of(file->mesh);
  std::string line = fmt::format("{}: {}, {:.3g} x {:.3g} x {:.3g} mm; {}", touched.mesh_file,
                                 counted(file->mesh.triangles.size(), "triangle"), mm_from_metres(size.x()),
                                 mm_from_metres(size.y()), mm_from_metres(size.z()), file->repaired.text());
  touched.mesh_hash = file->hash;
  touched.mesh = std::make_shared<scene::TriangleMesh>(std::move(file->mesh));
  return line;
}

Expected<void> find_touched_mesh(scene::SceneDescription& scene, const std::filesystem::path& given,
                                 bool same_machine) {
  auto& touched = scene.touched;
  if (touched.mesh_file.empty()) return {};
  if (given.empty() && !same_machine)
    return refused(
        "graphics: the physics server touches its file {}; copy it to this machine and name it with "
        "--mesh FILE",
        excerpt(touched.mesh_file, 200));
  const std::filesystem::path path = given.empty() ? std::filesystem::path(touched.mesh_file) : given;
  auto file = read_for_touch(path, touched.metres_per_unit);
  if (!file) return tl::unexpected(file.error());
  if (file->hash != touched.mesh_hash)
    return refused(
        "graphics: {} is not the mesh that the physics server touches ({} there, {} here); copy the "
        "server's file, or start the server again",
        path.string(), excerpt(touched.mesh_hash), file->hash);
  touched.mesh = std::make_shared<scene::TriangleMesh>(std::move(file->mesh));
  return {};
}

}  // namespace palpate::applications
