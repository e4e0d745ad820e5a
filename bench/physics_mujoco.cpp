// MuJoCo in bench/physics: Newton solver, elliptic cone, and the contact as our own model has it: a damped
// mass-spring of 4 ms that gives back 0.93.
#include "bench/physics_rivals.h"

#ifdef PALPATE_BENCH_MUJOCO
#include <fmt/core.h>
#include <mujoco/mujoco.h>

#include <cstring>
#include <stdexcept>

#include "palpate/physics/contact.h"

namespace palpate::bench {
namespace {

class MujocoEngine : public Engine {
 public:
  explicit MujocoEngine(const Setting& setting) {
    const physics::DampedContact law(kMass, kRestitution, kContact,
                                     physics::Release::where_rest_length_is_back);
    const bool box = setting.surfaces == Surfaces::box;
    const std::string table = box ? R"(<geom type="box" size="0.375 0.01 0.5" pos="0 -0.01 0.5")"
                                  : R"(<geom type="plane" size="0.375 0.5 0.1" pos="0 0 0.5" zaxis="0 1 0")";
    const std::string wall = box ? R"(<geom type="box" size="0.375 0.3 0.01" pos="0 0.3 -0.01")"
                                 : R"(<geom type="plane" size="0.375 0.3 0.1" pos="0 0.3 0" zaxis="0 0 1")";
    const std::string xml = fmt::format(
        R"(<mujoco><option timestep="{}" gravity="0 {} 0" cone="elliptic" solver="Newton"><flag refsafe="disable"/></option>
<default><geom solref="{} {}" solimp="0.9999 0.9999 0.001" friction="0 0 0" condim="1"/></default>
<worldbody>{}/>{}/>
<body name="bat" mocap="true" pos="0 9 0"><geom type="cylinder" size="0.075 0.006" zaxis="0 1 0"/></body>
<body name="ball"><freejoint/><geom type="sphere" size="{}" mass="{}"/></body></worldbody></mujoco>)",
        setting.dt, setting.gravity ? -9.81 : 0.0, -law.stiffness() / kMass, -law.damping() / kMass, table,
        wall, kRadius, kMass);
    auto vfs = std::make_unique<mjVFS>();
    mj_defaultVFS(vfs.get());
    mj_makeEmptyFileVFS(vfs.get(), "scene.xml", static_cast<int>(xml.size()));
    std::memcpy(vfs->filedata[mj_findFileVFS(vfs.get(), "scene.xml")], xml.data(), xml.size());
    char error[300] = "";
    model_ = mj_loadXML("scene.xml", vfs.get(), error, sizeof error);
    mj_deleteVFS(vfs.get());
    if (model_ == nullptr) throw std::runtime_error(std::string("bench/physics: MuJoCo says: ") + error);
    data_ = mj_makeData(model_);
  }
  MujocoEngine(const MujocoEngine&) = delete;
  MujocoEngine& operator=(const MujocoEngine&) = delete;
  ~MujocoEngine() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  void place(const Vector3& position, const Vector3& velocity) override {
    mj_resetData(model_, data_);
    for (int i = 0; i < 3; ++i) {
      data_->qpos[i] = position[i];
      data_->qvel[i] = velocity[i];
    }
    data_->qpos[3] = 1.0;
  }
  void step(const BatPlace&, const BatPlace& after) override {
    const auto& q = after.rotation;
    for (int i = 0; i < 3; ++i) data_->mocap_pos[i] = after.centre[i];
    data_->mocap_quat[0] = q.w();
    data_->mocap_quat[1] = q.x();
    data_->mocap_quat[2] = q.y();
    data_->mocap_quat[3] = q.z();
    mj_step(model_, data_);
  }
  Vector3 position() const override { return {data_->qpos[0], data_->qpos[1], data_->qpos[2]}; }
  Vector3 velocity() const override { return {data_->qvel[0], data_->qvel[1], data_->qvel[2]}; }

 private:
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
};

}  // namespace

std::unique_ptr<Engine> make_mujoco(const Setting& setting) {
  return std::make_unique<MujocoEngine>(setting);
}

}  // namespace palpate::bench

#else

namespace palpate::bench {
std::unique_ptr<Engine> make_mujoco(const Setting&) { return nullptr; }
}  // namespace palpate::bench

#endif
