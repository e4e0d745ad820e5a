// Bullet in bench/physics: default solver, continuous collision detection on, as its manual advises for fast
// small bodies (threshold a quarter of the radius, swept sphere three quarters).
#include "bench/physics_rivals.h"

#ifdef PALPATE_BENCH_BULLET
#include <btBulletDynamicsCommon.h>

#include <vector>

namespace palpate::bench {
namespace {

btVector3 bt(const Vector3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}
btTransform bt(const BatPlace& place) {
  const auto& q = place.rotation;
  return btTransform(btQuaternion(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                                  static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w())),
                     bt(place.centre));
}

class BulletEngine : public Engine {
 public:
  explicit BulletEngine(const Setting& setting)
      : dt_(setting.dt),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    world_.setGravity({0, setting.gravity ? btScalar(-9.81) : btScalar(0), 0});
    if (setting.surfaces == Surfaces::mesh) {
      const Vector3 x(0.75, 0, 0);
      add_fixed(scene::rectangle_mesh({-0.375, 0, 1.0}, x, {0, 0, -1.0}));
      add_fixed(scene::rectangle_mesh({-0.375, 0, 0}, x, {0, 0.6, 0}));
    } else {
      add_fixed({0, -0.5 * kThick, 0.5}, {0.375, 0.5 * kThick, 0.5});
      add_fixed({0, 0.3, -0.5 * kThick}, {0.375, 0.3, 0.5 * kThick});
    }
    auto& bat = add(std::make_unique<btCylinderShape>(btVector3(0.075f, 0.006f, 0.075f)), 0.0);
    bat.setCollisionFlags(bat.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    bat.setActivationState(DISABLE_DEACTIVATION);
    bat_ = &bat;
    ball_ = &add(std::make_unique<btSphereShape>(btScalar(kRadius)), kMass);
    ball_->setActivationState(DISABLE_DEACTIVATION);
    ball_->setCcdMotionThreshold(btScalar(0.25 * kRadius));
    ball_->setCcdSweptSphereRadius(btScalar(0.75 * kRadius));
  }
  ~BulletEngine() override {
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  void place(const Vector3& position, const Vector3& velocity) override {
    const btTransform at(btQuaternion::getIdentity(), bt(position));
    ball_->setWorldTransform(at);
    ball_->setInterpolationWorldTransform(at);
    ball_->setLinearVelocity(bt(velocity));
    ball_->setAngularVelocity({0, 0, 0});
    ball_->clearForces();
  }
  void step(const BatPlace& before, const BatPlace& after) override {
    bat_->setInterpolationWorldTransform(bt(before));  // Bullet takes the bat's velocity from the two
    bat_->setWorldTransform(bt(after));
    world_.stepSimulation(static_cast<btScalar>(dt_), 0);
  }
  Vector3 position() const override {
    const auto& p = ball_->getWorldTransform().getOrigin();
    return {p.x(), p.y(), p.z()};
  }
  Vector3 velocity() const override {
    const auto& v = ball_->getLinearVelocity();
    return {v.x(), v.y(), v.z()};
  }

 private:
  btRigidBody& add(std::unique_ptr<btCollisionShape> shape, double mass,
                   const Vector3& at = Vector3::Zero()) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0.0) shape->calculateLocalInertia(static_cast<btScalar>(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, shape.get(), inertia);
    info.m_startWorldTransform.setOrigin(bt(at));
    info.m_restitution =
        mass > 0.0 ? 1.0f : static_cast<btScalar>(kRestitution);  // Bullet multiplies the two
    info.m_friction = 0.0f;
    shapes_.push_back(std::move(shape));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    world_.addRigidBody(bodies_.back().get());
    return *bodies_.back();
  }
  void add_fixed(const Vector3& centre, const Vector3& half) {
    add(std::make_unique<btBoxShape>(bt(half)), 0.0, centre);
  }
  void add_fixed(const scene::TriangleMesh& mesh) {
    meshes_.push_back(std::make_unique<btTriangleMesh>());
    for (const auto& t : mesh.triangles)
      meshes_.back()->addTriangle(bt(mesh.vertices[t[0]]), bt(mesh.vertices[t[1]]), bt(mesh.vertices[t[2]]));
    add(std::make_unique<btBvhTriangleMeshShape>(meshes_.back().get(), true), 0.0);
  }

  double dt_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  std::vector<std::unique_ptr<btTriangleMesh>> meshes_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  btDiscreteDynamicsWorld world_;
  btRigidBody *bat_ = nullptr, *ball_ = nullptr;
};

class BulletSweeper : public Sweeper {
 public:
  explicit BulletSweeper(const scene::TriangleMesh& mesh)
      : dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &configuration_),
        sphere_(btScalar(kRadius)) {
    for (const auto& t : mesh.triangles)
      triangles_.addTriangle(bt(mesh.vertices[t[0]]), bt(mesh.vertices[t[1]]), bt(mesh.vertices[t[2]]));
    shape_ = std::make_unique<btBvhTriangleMeshShape>(&triangles_, true);
    object_.setCollisionShape(shape_.get());
    world_.addCollisionObject(&object_);
  }
  ~BulletSweeper() override { world_.removeCollisionObject(&object_); }
  std::optional<double> first(const Vector3& from, const Vector3& to) override {
    const btVector3 a = bt(from), b = bt(to);
    btCollisionWorld::ClosestConvexResultCallback result(a, b);
    const auto straight = btQuaternion::getIdentity();
    world_.convexSweepTest(&sphere_, btTransform(straight, a), btTransform(straight, b), result);
    if (!result.hasHit()) return std::nullopt;
    return result.m_closestHitFraction;
  }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_;
  btSphereShape sphere_;
  btTriangleMesh triangles_;
  std::unique_ptr<btBvhTriangleMeshShape> shape_;
  btCollisionObject object_;
};

}  // namespace

std::unique_ptr<Engine> make_bullet(const Setting& setting) {
  return std::make_unique<BulletEngine>(setting);
}
std::unique_ptr<Sweeper> make_bullet_sweeper(const scene::TriangleMesh& mesh) {
  return std::make_unique<BulletSweeper>(mesh);
}

}  // namespace palpate::bench

#else

namespace palpate::bench {
std::unique_ptr<Engine> make_bullet(const Setting&) { return nullptr; }
std::unique_ptr<Sweeper> make_bullet_sweeper(const scene::TriangleMesh&) { return nullptr; }
}  // namespace palpate::bench

#endif
