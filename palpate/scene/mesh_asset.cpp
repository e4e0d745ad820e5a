#include "palpate/scene/mesh_asset.h"

#include <fmt/format.h>

#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/scene/mesh_file.h"

namespace palpate::scene {
namespace {

Vector3 size_of(const TriangleMesh& mesh) {
  Vector3 low = mesh.vertices.front(), high = low;
  for (const auto& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return high - low;
}

Expected<MeshFile> read_within_limits(const std::filesystem::path& path, double metres_per_unit) {
  auto file = read_mesh(path, metres_per_unit);
  if (!file) return file;
  const Vector3 size = size_of(file->mesh);
  if (size.maxCoeff() < kSmallestMesh || size.maxCoeff() > kLargestMesh)
    return wrong_use(
        "{}: is {:g} x {:g} x {:g} mm large; a largest side of {:.0f} to {:.0f} mm is expected; check "
        "the unit (--unit, or unit among the settings) or choose a scale",
        path.string(), mm_from_metres(size.x()), mm_from_metres(size.y()), mm_from_metres(size.z()),
        mm_from_metres(kSmallestMesh), mm_from_metres(kLargestMesh));
  if (file->mesh.triangles.size() > kMostMeshTriangles)
    return wrong_use("{}: has {} triangles; at most {} are expected, which are felt in time; simplify it",
                     path.string(), file->mesh.triangles.size(), kMostMeshTriangles);
  return file;
}

}  // namespace

Expected<std::string> read_mesh_asset(SceneDescription& scene) {
  if (!scene.mesh || scene.mesh->file.empty()) return std::string();
  MeshAsset& asset = *scene.mesh;
  if (asset.file.size() > kMaxMeshPathBytes)
    return wrong_use("{}: the path has {} bytes, at most {} are expected; put the file elsewhere",
                     excerpt(asset.file), asset.file.size(), kMaxMeshPathBytes);
  auto file = read_within_limits(asset.file, asset.metres_per_unit);
  if (!file) return tl::unexpected(file.error());
  const Vector3 size = size_of(file->mesh);
  std::string line = fmt::format("{}: {}, {:.3g} x {:.3g} x {:.3g} mm; {}", asset.file,
                                 counted(file->mesh.triangles.size(), "triangle"), mm_from_metres(size.x()),
                                 mm_from_metres(size.y()), mm_from_metres(size.z()), file->repaired.text());
  asset.hash = file->hash;
  asset.mesh = std::make_shared<TriangleMesh>(std::move(file->mesh));
  return line;
}

Expected<void> find_mesh_asset(SceneDescription& scene, const std::filesystem::path& given,
                               bool same_machine) {
  if (!scene.mesh || scene.mesh->file.empty()) return {};
  MeshAsset& asset = *scene.mesh;
  if (given.empty() && !same_machine)
    return refused(
        "graphics: the physics server uses its file {}; copy it to this machine and name it with "
        "--mesh FILE",
        excerpt(asset.file, 200));
  const std::filesystem::path path = given.empty() ? std::filesystem::path(asset.file) : given;
  auto file = read_within_limits(path, asset.metres_per_unit);
  if (!file) return tl::unexpected(file.error());
  if (file->hash != asset.hash)
    return refused(
        "graphics: {} is not the mesh that the physics server uses ({} there, {} here); copy the "
        "server's file, or start the server again",
        path.string(), excerpt(asset.hash), file->hash);
  asset.mesh = std::make_shared<TriangleMesh>(std::move(file->mesh));
  return {};
}

}  // namespace palpate::scene
