// Embree in bench/physics: the ray of the centre, which is all it offers; no swept sphere.
#include "bench/physics_rivals.h"

#ifdef PALPATE_BENCH_EMBREE
#include <embree3/rtcore.h>

#include <cmath>

namespace palpate::bench {
namespace {

class EmbreeRay : public Sweeper {
 public:
  explicit EmbreeRay(const TriangleMesh& mesh)
      : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                          RTC_FORMAT_FLOAT3, 12, mesh.vertices.size()));
    for (const auto& vertex : mesh.vertices)
      for (int i = 0; i < 3; ++i) *v++ = static_cast<float>(vertex[i]);
    auto* t = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                                             RTC_FORMAT_UINT3, 12, mesh.triangles.size()));
    for (const auto& triangle : mesh.triangles)
      for (const auto i : triangle) *t++ = i;
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  EmbreeRay(const EmbreeRay&) = delete;
  EmbreeRay& operator=(const EmbreeRay&) = delete;
  ~EmbreeRay() override {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  std::optional<double> first(const Vector3& from, const Vector3& to) override {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray{};
    ray.ray.org_x = static_cast<float>(from.x());
    ray.ray.org_y = static_cast<float>(from.y());
    ray.ray.org_z = static_cast<float>(from.z());
    ray.ray.dir_x = static_cast<float>(to.x() - from.x());
    ray.ray.dir_y = static_cast<float>(to.y() - from.y());
    ray.ray.dir_z = static_cast<float>(to.z() - from.z());
    ray.ray.tfar = 1.0f;
    ray.ray.mask = ~0u;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return ray.ray.tfar;
  }

 private:
  RTCDevice device_;
  RTCScene scene_;
};

}  // namespace

std::unique_ptr<Sweeper> make_embree_ray(const TriangleMesh& mesh) {
  return std::make_unique<EmbreeRay>(mesh);
}

}  // namespace palpate::bench

#else

namespace palpate::bench {
std::unique_ptr<Sweeper> make_embree_ray(const TriangleMesh&) { return nullptr; }
}  // namespace palpate::bench

#endif
