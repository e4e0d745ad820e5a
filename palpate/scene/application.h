// What an application is to the system: rules and bodies on the physics side, things to draw
// on the graphics side. A few hundred lines each; the servers know nothing else about it.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/math/pose.h"
#include "palpate/scene/contact_law.h"
#include "palpate/scene/draw_item.h"
#include "palpate/scene/mesh.h"
#include "palpate/scene/payload.h"
#include "palpate/scene/scene_state.h"

namespace palpate::scene {

// A real rectangle as calibrated: corners in touching order, World, m; its front is corner[1]-corner[0] x
// corner[3]-corner[0]. Of a table the edge from corner 0 to 1 is the one nearest the person.
struct SceneSurface {
  std::string name;
  std::array<Vector3, 4> corners;
};

// The course of an impact's force (physics/contact.h, hunt_crossley.h): a spring that lets go where its force
// is zero, the 2006 paper's that pulls at its end, or one that stiffens and damps with depth.
enum class ContactModel : std::uint8_t { non_sticky, paper, hunt_crossley };

inline constexpr std::size_t kLongestBodyName = 64;  // bytes

// What body 0, 1, ... of a state is.
struct BodyDescription {
  std::string name;   // as its pose is published: "Ball" as BallToWorld; empty: it is not
  double mass = 0.0;  // kg; 0: it is not said, or held fast
};

// A mesh file that both sides read. Over the network go file, hash and unit; who gets them reads the same
// file, or a copy of it.
struct MeshAsset {
  std::string file;  // on the physics server's machine
  std::string hash;  // of its bytes; empty until it is read
  double metres_per_unit = 0.001;
  std::shared_ptr<const TriangleMesh> mesh;  // as read
};

// What physics and picture both have to know before they start; the physics server sends it to whoever
// connects.
struct SceneDescription {
  std::string application;
  std::vector<SceneSurface> surfaces;
  Vector3 gravity{0.0, -9.81, 0.0};
  // From the stylus tip to the origin of the body it carries, in Tip, m; that body's axes are the Tip's.
  Vector3 carried_offset = Vector3::Zero();
  std::vector<BodyDescription> bodies;  // at most SceneState::kBodies
  std::optional<MeshAsset> mesh;
  Payload settings;                // the application's own (palpate/scene/setting_schema.h)
  std::size_t shape_vertices = 0;  // of the surface that deforms; 0: there is none
  // Where the rig puts the arm's tip at a few readings (rig::tips_of_arm), m, World; empty: it has no arm.
  std::vector<Vector3> arm_tips;
  static constexpr std::size_t kMostArmTips = 9;
};

// An impact the hand must feel: starts at `start`, lasts `duration`; impulse along `direction` (on the hand,
// World).
struct ImpactEvent {
  std::uint64_t number = 0;  // 1, 2, ... by the application
  Instant<PhysicsClock> start;
  Duration duration{0};
  Vector3 direction = Vector3::Zero();  // unit, force on the hand
  Vector3 point = Vector3::Zero();      // World, where it acts
  double approach_speed = 0.0;          // normal component of the relative velocity, m/s, > 0
  double mass = 0.0;                    // effective: of what hits, and less where what it hits recoils; kg
  double restitution = 1.0;
  ContactModel model = ContactModel::non_sticky;  // the force's course over `duration`

  // None yet: what stands where an application has had no impact.
  bool none() const { return number == 0; }
  double impulse() const { return mass * (1.0 + restitution) * approach_speed; }  // N s, along `direction`
};

enum class Control : std::uint8_t { none, begin, reset, pause, resume };

// The body that the stylus carries: SceneDescription::carried_offset leads from the stylus tip to it.
inline constexpr std::size_t kCarried = 1;

// Physics side. step() runs in the physics loop: no lock, no allocation, no exception, no text.
class Application {
 public:
  virtual ~Application() = default;
  // Advances the virtual world to `now` (dt since the last call) with the stylus at `tip`. `state` arrives as the
  // last step left it, with time and tick of this one; bodies and their number, counters, impact and continuous
  // force are filled in here. The force of a contact law comes into the picture only if it is written there, too.
  virtual void step(Instant<PhysicsClock> now, Duration dt, const TipState& tip, SceneState& state) = 0;
  // What is felt as a blow: the newest impact, number 0 if none so far.
  virtual const ImpactEvent& impact() const = 0;
  // What is felt continuously, where the haptic tick is to say so itself; null: the force that step() puts
  // into the state. Asked for once; lives as long as the application. Its force() is the haptic thread's.
  virtual ContactLaw* contact_law() { return nullptr; }
  // The surface that deforms as it is now, as Shape::values; always of the same size. Empty: there is none.
  virtual std::span<const float> shape() const { return {}; }
  // A person's wish, between two steps.
  void control(Control command) {
    if (command == Control::pause || command == Control::resume) paused_ = command == Control::pause;
    if (command == Control::begin) begin();
    if (command == Control::reset) reset();
  }

 protected:
  bool paused() const { return paused_; }

 private:
  virtual void begin() = 0;  // whatever a person begins here: the next round, a motion
  virtual void reset() = 0;  // back to the start, counters to zero
  bool paused_ = false;
};

// Graphics side.
class SceneView {
 public:
  virtual ~SceneView() = default;
  virtual std::vector<DrawItem> draw(const SceneState& state) const = 0;
  // The surface that deforms, as it is in the pictures drawn from now on; null: it is not known, or there is none.
  virtual void set_shape(const std::shared_ptr<const Shape>& /*shape*/) {}
  // Ways in which it can be drawn, as a person calls them, the usual one first; empty: there is one.
  virtual std::vector<std::string> looks() const { return {}; }
  virtual void set_look(std::size_t /*which*/) {}
  // The one of these that suits a person at a window, who has one eye and no depth to go by.
  virtual std::size_t look_at_window() const { return 0; }
  // The state carried on by `ahead`, for a picture of the near future. Bodies move on steadily; an
  // application whose bodies fall or meet others says so itself, and never guesses beyond a contact.
  virtual SceneState predict(const SceneState& state, Duration ahead) const {
    return extrapolate(state, ahead);
  }
  // Lines of text for a person (score, rally), newest state.
  virtual std::vector<std::string> captions(const SceneState& state) const = 0;
};

}  // namespace palpate::scene
