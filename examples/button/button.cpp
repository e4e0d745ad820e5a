// A push button on the table that clicks under the stylus: it gives way like a spring, snaps through, comes back.
#include <algorithm>
#include <atomic>

#include "palpate/plugin/plugin.h"
#include "palpate/scene/table_frame.h"
#include "palpate/time/triple_buffer.h"

namespace {
using namespace palpate;
using namespace palpate::scene;

constexpr double kTip = 0.003, kRadius = 0.018, kHeight = 0.08;   // m: stylus ball, cap, how high it stands
constexpr double kSnap = 0.0045, kBack = 0.002, kTravel = 0.006;  // m: snaps there, comes back here, the stop
constexpr double kSpring = 400.0, kStop = 350.0, kDamping = 1.0;  // N/m, N/m, N s/m
constexpr double kGivesWay = 0.65, kSnapTime = 0.012;             // share of the spring lost by a snap; s
constexpr double kTeleport = 0.05;                                // m in a tick: the tip came by another way
enum BodyOrCounter { kCap = 0, kStylus = 1, kClicks = 0, kDown = 1, kForceMn = 2 };

struct Place : TableFrame {
  explicit Place(const SceneDescription& scene) : TableFrame(table_frame(scene)) {}
  Vector3 top = edge + 0.08 * right + kHeight * up - 0.07 * near;  // the middle of the cap at rest
};

struct Found {  // by the newest haptic tick
  Vector3 force = Vector3::Zero(), tip = Vector3::Zero();
  double depth = 0.0;
  int clicks = 0, down = 0;
};

class Button : public Application, public ContactLaw {
 public:
  explicit Button(const SceneDescription& scene) : at_(scene) {}
  Vector3 force(const TipState& tip, double dt) noexcept override {  // the haptic thread
    const Vector3 p = tip.X_world_tip.translation, r = p - at_.top;
    const double height = at_.up.dot(r), aside = (r - height * at_.up).norm();
    const double depth = std::max(0.0, kTip - height);
    if (off_ || aside > kRadius || (p - found_.tip).norm() > kTeleport)
      entered_ = 0;
    else if (depth == 0.0)
      entered_ = 1;  // from above alone
    found_.tip = p;
    found_.depth = entered_ ? depth : 0.0;
    if (found_.depth > kSnap && !found_.down) ++found_.clicks;
    found_.down = found_.depth > (found_.down ? kBack : kSnap);
    snapped_ += std::clamp((found_.down ? 1.0 : 0.0) - snapped_, -dt / kSnapTime, dt / kSnapTime);
    const double spring = kSpring * (1.0 - kGivesWay * snapped_) * found_.depth;
    const double stop = kStop * std::max(0.0, found_.depth - kTravel);
    const double damper = -kDamping * std::min(1.0, found_.depth / 0.001) * at_.up.dot(tip.velocity);
    const double edge = std::clamp((kRadius - aside) / 0.003, 0.0, 1.0);  // no jump where the tip slips off
    found_.force = edge * std::clamp(spring + stop + damper, 0.0, force_bound()) * at_.up;
    newest_.write(found_);
    return found_.force;
  }
  double force_bound() const override { return 20.0; }
  Duration cost_bound() const override { return std::chrono::microseconds(50); }
  void step(Instant<PhysicsClock>, Duration, const TipState& tip, SceneState& state) override {
    off_ = paused();
    newest_.read(now_);
    state.body_count = 2;
    state.bodies[kCap].set_p(at_.top - std::min(now_.depth, kTravel) * at_.up);
    state.bodies[kCap].set_q(at_.rotation);
    state.bodies[kStylus].set_p(tip.X_world_tip.translation);  // the bare stylus carries nothing
    state.bodies[kStylus].set_q(tip.X_world_tip.rotation);
    state.bodies[kStylus].set_v(tip.velocity);
    state.counters[kClicks] = now_.clicks - before_reset_;
    state.counters[kDown] = now_.down;
    state.counters[kForceMn] = static_cast<std::int32_t>(1000.0 * now_.force.norm());
    state.continuous = {.force = {now_.force.x(), now_.force.y(), now_.force.z()},
                        .point = {now_.tip.x(), now_.tip.y(), now_.tip.z()},
                        .touching = now_.depth > 0.0};
  }
  const ImpactEvent& impact() const override { return none_; }
  ContactLaw* contact_law() override { return this; }

 private:
  void begin() override {}
  void reset() override { before_reset_ = now_.clicks; }
  const Place at_;
  std::atomic<bool> off_ = false;
  TripleBuffer<Found> newest_;
  Found found_, now_;  // the haptic thread's, the physics thread's
  double snapped_ = 0.0;
  int entered_ = 0, before_reset_ = 0;
  ImpactEvent none_;
};

struct View : SceneView {
  explicit View(const SceneDescription& scene) : at(scene) {}
  std::vector<DrawItem> draw(const SceneState& s) const override {
    const BodyState& b = s.bodies[kCap];
    const Look look{s.counters[kDown] ? std::array{0.05f, 0.45f, 0.08f} : std::array{0.45f, 0.02f, 0.02f}};
    return {{.mesh = &cap, .look = look, .rotation = b.q(), .position = b.p()},
            {.mesh = &housing, .rotation = b.q(), .position = at.top},
            {.mesh = &tip, .position = s.bodies[kStylus].p(), .sphere_radius = kTip}};
  }
  std::vector<std::string> captions(const SceneState& s) const override {
    return {"clicks: " + std::to_string(s.counters[kClicks]), std::to_string(s.counters[kForceMn]) + " mN"};
  }
  Place at;
  TriangleMesh cap = cylinder_mesh({0, -0.02, 0}, {0, 0, 0}, kRadius), tip = sphere_mesh(kTip),
               housing = cylinder_mesh({0, -kHeight, 0}, {0, -0.009, 0}, kRadius + 0.006);
};

struct Finger : Player {  // comes down until it is shown a click, goes up, and again
  Finger(const SceneDescription& scene, const Reach& reach, const PlayerSettings& settings)
      : at(scene), set(settings), hand(set.hand, set.max_acceleration, reach.home()), rest{reach.home()} {}
  void show(const SceneState& s, Instant<PhysicsClock> displayed) override {
    if (s.counters[kClicks] > seen && down) react = displayed.seconds() + set.reaction_s;
    seen = s.counters[kClicks];
  }
  void go(const HandState& from, bool to_press, double duration, double now) {
    const Vector3 goal = at.top + ((to_press ? -0.04 : 0.02) + kTip) * at.up;
    path = Quintic(from, {goal}, duration), begin = now, down = to_press, react = 1e18;
  }
  device::HandTarget act(Instant<PhysicsClock> now) override {
    const double t = now.seconds();
    if (begin < 0.0) go(rest, false, 2.0, t);
    if (t - begin > path.duration() || t > react) go(path.at(t - begin), !down, down ? 0.8 : 1.5, t);
    const HandState& to = hand.follow(
        t, [&](double u) { return path.at(u - begin); }, [&](double u) { return path.jerk(u - begin); });
    return {{to.position}, to.velocity, Quaternion::FromTwoVectors(Vector3::UnitZ(), at.up)};
  }
  void take_over(const device::HandTarget& h, Instant<PhysicsClock> now) override {
    hand = HandTrajectory(set.hand, set.max_acceleration, h.tip.m, h.velocity);
    go({h.tip.m, h.velocity}, false, 2.0, now.seconds());
  }
  const Place at;
  const PlayerSettings set;
  HandTrajectory hand;
  const HandState rest;
  Quintic path;
  double begin = -1.0, react = 1e18;
  int seen = 0, down = 0;
};
}  // namespace
void add_button(plugin::Guests& guests) {
  ApplicationSpec spec;
  spec.name = "button", spec.summary = "Press a button that clicks under the stylus",
  spec.surfaces = {"table"};
  spec.describe = [](const SettingValues&, SceneDescription& s) { s.bodies = {{"Cap"}, {"Stylus"}}; };
  spec.make_physics = [](const auto& s, const auto&) { return std::make_unique<Button>(s); };
  spec.make_view = [](const SceneDescription& s) { return std::make_unique<View>(s); };
  spec.make_player = [](const auto& s, const auto& r, const auto& p) {
    return std::make_unique<Finger>(s, r, p);
  };
  guests.applications.add(spec);
}
PALPATE_PLUGIN("button", add_button)
