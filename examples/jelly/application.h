// The jelly on the physics side: what the hand feels, evaluated in the haptic tick (JellyLaw), and what moves
// (JellyApplication). The two loops hand each other the newest surface and the newest force; neither waits. World, SI.
#pragma once

#include <vector>

#include "palpate/scene/application.h"
#include "palpate/time/triple_buffer.h"
#include "soft_body.h"

namespace jelly {

inline constexpr double kTipRadius = 0.004;  // m

// Of a state: its bodies, and the places of its counters.
inline constexpr int kJelly = 0, kStylus = 1, kTip = 2;
enum Counter : std::size_t {
  kPresses,  // times it was met
  kForceMn,  // now, mN
  kPeakMn,   // so far
  kDentUm,   // now, deepest vertex against the mould, um
};

// What the haptic tick found.
struct Felt {
  palpate::Vector3 force = palpate::Vector3::Zero();  // N on the hand
  bool engaged = false;                               // the tip has been outside
  bool touching = false;
  std::int32_t presses = 0;
};

class JellyLaw : public palpate::scene::ContactLaw {
 public:
  JellyLaw(const palpate::Pose<palpate::World, JellyFrame>& X_world_jelly,
           std::vector<palpate::Vector3> facing, const Surface& rest);

  // --- the haptic thread
  palpate::Vector3 force(const palpate::scene::TipState& tip, double dt) noexcept override;
  double force_bound() const override { return 8.0; }
  palpate::Duration cost_bound() const override { return std::chrono::microseconds(300); }

  // --- the physics thread
  void set_surface(const Surface& surface) { moved_.write(surface); }
  const Felt& newest() {
    found_.read(newest_);
    return newest_;
  }

 private:
  palpate::Pose<palpate::World, JellyFrame> X_world_jelly_;
  std::vector<palpate::Vector3> facing_;
  palpate::Vector3 tip_before_ = palpate::Vector3::Zero();
  Surface surface_;  // the haptic thread's
  Felt felt_, newest_;
  palpate::TripleBuffer<Surface> moved_;
  palpate::TripleBuffer<Felt> found_;
};

class JellyApplication : public palpate::scene::Application {
 public:
  explicit JellyApplication(const palpate::scene::SceneDescription& scene);

  void step(palpate::Instant<palpate::PhysicsClock> now, palpate::Duration dt,
            const palpate::scene::TipState& tip, palpate::scene::SceneState& state) override;
  const palpate::scene::ImpactEvent& impact() const override { return no_impact_; }
  palpate::scene::ContactLaw* contact_law() override { return &law_; }
  std::span<const float> shape() const override { return shape_; }

 private:
  void begin() override;  // a knock on the plate: all of it wobbles
  void reset() override;
  void move(double dt, const palpate::Vector3& tip);
  void shape_anew();
  void show(const palpate::scene::TipState& tip, const Felt& felt, palpate::scene::SceneState& state);

  palpate::Vector3 carried_offset_;
  palpate::Pose<palpate::World, JellyFrame> X_world_jelly_;
  SoftBody body_;
  std::vector<palpate::Vector3> facing_;  // of the mould
  Surface surface_;
  JellyLaw law_;
  Contact contact_;
  std::vector<palpate::Vector3> normals_;
  std::vector<float> shape_;
  double dent_ = 0.0, peak_ = 0.0;  // m, N
  std::int32_t presses_before_ = 0;
  bool knocked_ = false;
  palpate::scene::ImpactEvent no_impact_;
};

}  // namespace jelly
