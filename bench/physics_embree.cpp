// Embree in bench/physics: the ray of the centre, which is all it offers; no swept sphere.
#include "bench/physics_rivals.h"

#ifdef PALPATE_BENCH_EMBREE
#include "tests/embree_rays.h"

namespace palpate::bench {
namespace {

class EmbreeRay : public Sweeper {
 public:
  explicit EmbreeRay(const scene::TriangleMesh& mesh) : rays_(mesh) {}
  std::optional<double> first(const Vector3& from, const Vector3& to) override {
    return rays_.first(from, to - from);
  }

 private:
  EmbreeRays rays_;
};

}  // namespace

std::unique_ptr<Sweeper> make_embree_ray(const scene::TriangleMesh& mesh) {
  return std::make_unique<EmbreeRay>(mesh);
}

}  // namespace palpate::bench

#else

namespace palpate::bench {
std::unique_ptr<Sweeper> make_embree_ray(const scene::TriangleMesh&) { return nullptr; }
}  // namespace palpate::bench

#endif
