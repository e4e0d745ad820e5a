// Bullet's deformable body in bench/indent: implicit steps, neo-Hookean tetrahedra, a kinematic sphere, contact of faces and nodes, as its
// examples set it up. Lengths in centimetres, so that Bullet's single precision and margins are at ease.
#include "bench/indent_rival.h"

#ifdef PALPATE_BENCH_BULLET_SOFT
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "palpate/core/statistics.h"

namespace palpate::bench {
namespace {

constexpr double kUnit = 100.0;             // lengths in Bullet per metre
constexpr double kForceUnit = 1.0 / kUnit;  // N per kg cm/s^2
constexpr double kDensity = 1000.0, kStep = 1.0 / 240.0, kSpeed = 0.02, kHold = 0.3;
constexpr float kMargin = 0.02f, kDamping = 0.05f;

class BulletBlock : public Rival {
 public:
  explicit BulletBlock(const RivalBlock& block)
      : block_(block),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &constraints(), &configuration_, &solver_) {
    world_.setGravity({0, 0, 0});
    world_.getWorldInfo().m_gravity.setZero();
    world_.getWorldInfo().m_sparsesdf.setDefaultVoxelsz(0.25f);
    world_.getWorldInfo().m_sparsesdf.Reset();
    add_body();
    add_sphere();
  }
  ~BulletBlock() override {
    world_.removeRigidBody(&*sphere_);
    world_.removeForce(body_.get(), &force_);
    world_.removeSoftBody(body_.get());
  }
  BulletBlock(const BulletBlock&) = delete;
  BulletBlock& operator=(const BulletBlock&) = delete;

  RivalPress press_to(double depth) override {
    for (; depth_ < depth; depth_ = std::min(depth, depth_ + kSpeed * kStep)) step();
    depth_ = depth;
    RivalPress press{.depth = depth, .lowest = 1e30, .highest = -1e30};
    const int held = static_cast<int>(kHold / kStep), last = held / 3;
    for (int i = 0; i < held; ++i) {
      step();
      if (i < held - last) continue;
      const double now = force_on_table();
      press.force += now / last;
      press.lowest = std::min(press.lowest, now);
      press.highest = std::max(press.highest, now);
    }
    const btVector3 centre = sphere_->getWorldTransform().getOrigin();
    for (int i = 0; i < body_->m_nodes.size(); ++i)
      press.inside += (body_->m_nodes[i].m_x - centre).length() < 0.98 * block_.radius * kUnit ? 1 : 0;
    return press;
  }
  int nodes() const override { return body_->m_nodes.size(); }
  double ms_per_step() const override { return quantile(took_, 0.5); }

 private:
  btDeformableMultiBodyConstraintSolver& constraints() {
    constraints_.setDeformableSolver(&solver_);
    return constraints_;
  }
  int node_at(int i, int j, int k) const { return (i * (block_.across + 1) + j) * (block_.up + 1) + k; }

  void add_body() {
    const Vector3 size = kUnit * block_.size;
    btAlignedObjectArray<btVector3> places;
    btAlignedObjectArray<btScalar> masses;
    for (int i = 0; i <= block_.across; ++i)
      for (int j = 0; j <= block_.across; ++j)
        for (int k = 0; k <= block_.up; ++k) {
          const auto part = [](int n, int of, double length) {
            return static_cast<btScalar>(length * n / of);
          };
          places.push_back({part(i, block_.across, size.x()) - static_cast<btScalar>(0.5 * size.x()),
                            part(k, block_.up, size.z()),
                            part(j, block_.across, size.y()) - static_cast<btScalar>(0.5 * size.y())});
          masses.push_back(1);
        }
    body_ = std::make_unique<btSoftBody>(&world_.getWorldInfo(), places.size(), &places[0], &masses[0]);
    for (int i = 0; i < block_.across; ++i)
      for (int j = 0; j < block_.across; ++j)
        for (int k = 0; k < block_.up; ++k) add_cell(i, j, k);
    for (const auto& [first, second] : edges_)
      body_->appendLink(first, second);  // its node tree is built along them
    btSoftBodyHelpers::generateBoundaryFaces(body_.get());
    body_->initializeDmInverse();
    body_->m_tetraScratches.resize(body_->m_tetras.size());
    body_->m_tetraScratchesTn.resize(body_->m_tetras.size());
    body_->setTotalMass(static_cast<btScalar>(kDensity * block_.size.prod()));
    for (int i = 0; i <= block_.across; ++i)
      for (int j = 0; j <= block_.across; ++j) body_->setMass(node_at(i, j, 0), 0);
    body_->getCollisionShape()->setMargin(kMargin);
    body_->m_cfg.kKHR = 1, body_->m_cfg.kCHR = 1, body_->m_cfg.kDF = 0;
    body_->m_cfg.collisions =
        btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN | btSoftBody::fCollision::SDF_RDF;
    body_->m_sleepingThreshold = 0;
    world_.addSoftBody(body_.get());
    force_.setYoungsModulus(static_cast<btScalar>(block_.young / kUnit));
    force_.setPoissonRatio(static_cast<btScalar>(block_.poisson));
    force_.setDamping(kDamping);
    world_.addForce(body_.get(), &force_);
    world_.setImplicit(true);
    world_.setLineSearch(false);
    world_.setUseProjection(true);
  }
  // Five tetrahedra a cell, turned in every other one so that the faces meet.
  void add_cell(int i, int j, int k) {
    int c[8];
    for (int n = 0; n < 8; ++n) c[n] = node_at(i + (n & 1), j + (n >> 1 & 1), k + (n >> 2 & 1));
    static constexpr int kEven[5][4] = {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}, {1, 2, 4, 7}};
    static constexpr int kOdd[5][4] = {{1, 0, 5, 3}, {2, 3, 6, 0}, {4, 5, 0, 6}, {7, 6, 3, 5}, {0, 3, 5, 6}};
    for (const auto& t : (i + j + k) % 2 == 0 ? kEven : kOdd) {
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < a; ++b) edges_.insert(std::minmax(c[t[a]], c[t[b]]));
      const btVector3 o = body_->m_nodes[c[t[0]]].m_x;
      const btScalar volume = (body_->m_nodes[c[t[1]]].m_x - o)
                                  .cross(body_->m_nodes[c[t[2]]].m_x - o)
                                  .dot(body_->m_nodes[c[t[3]]].m_x - o);
      if (volume > 0)
        body_->appendTetra(c[t[0]], c[t[1]], c[t[2]], c[t[3]]);
      else
        body_->appendTetra(c[t[0]], c[t[2]], c[t[1]], c[t[3]]);
    }
  }
  btTransform sphere_place() const {
    const double aside = block_.between_nodes ? 0.5 * block_.size.x() / block_.across : 0.0;
    btTransform place;
    place.setIdentity();
    place.setOrigin({static_cast<btScalar>(kUnit * aside),
                     static_cast<btScalar>(kUnit * (block_.size.z() + block_.radius - depth_)),
                     static_cast<btScalar>(kUnit * aside)});
    return place;
  }
  void add_sphere() {
    shape_.emplace(static_cast<btScalar>(kUnit * block_.radius));
    sphere_.emplace(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &*shape_));
    sphere_->setCollisionFlags(sphere_->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    sphere_->setActivationState(DISABLE_DEACTIVATION);
    sphere_->setFriction(0);
    sphere_->setWorldTransform(sphere_place());
    world_.addRigidBody(&*sphere_);
  }
  void step() {
    sphere_->setInterpolationWorldTransform(
        sphere_->getWorldTransform());  // its velocity is taken from the two
    sphere_->setWorldTransform(sphere_place());
    const auto begins = std::chrono::steady_clock::now();
    world_.stepSimulation(static_cast<btScalar>(kStep), 0);
    took_.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begins).count());
  }
  // What the matter presses on the nodes that are held; at rest, what the sphere presses.
  double force_on_table() {
    btDeformableLagrangianForce::TVStack forces;
    forces.resize(body_->m_nodes.size(), btVector3(0, 0, 0));
    body_->updateDeformation();
    force_.addScaledElasticForce(1, forces);
    double sum = 0.0;
    for (int i = 0; i < body_->m_nodes.size(); ++i)
      if (body_->m_nodes[i].m_im == 0) sum -= static_cast<double>(forces[body_->m_nodes[i].index].y());
    return kForceUnit * sum;
  }

  RivalBlock block_;
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btDeformableBodySolver solver_;
  btDeformableMultiBodyConstraintSolver constraints_;
  btDeformableMultiBodyDynamicsWorld world_;
  btDeformableNeoHookeanForce force_;
  std::unique_ptr<btSoftBody> body_;
  std::optional<btSphereShape> shape_;
  std::optional<btRigidBody> sphere_;
  std::set<std::pair<int, int>> edges_;
  double depth_ = 0.0;
  std::vector<double> took_;
};

}  // namespace

std::unique_ptr<Rival> make_bullet_block(const RivalBlock& block) {
  return std::make_unique<BulletBlock>(block);
}

}  // namespace palpate::bench

#else

namespace palpate::bench {
std::unique_ptr<Rival> make_bullet_block(const RivalBlock&) { return nullptr; }
}  // namespace palpate::bench
#endif
