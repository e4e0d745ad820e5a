#include "palpate/sim/simulator.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "palpate/sim/internal/sim_person.h"
#include "palpate/sim/simulated_arm.h"
#include "palpate/sim/simulated_tracker.h"

namespace palpate::sim {

struct Simulator::Parts : device::ArmDevice, device::TrackerDevice, device::HandDevice, Clock<PhysicsClock> {
  Parts(config::WorldFile world, std::uint64_t seed_number, std::uint64_t visit)
      : file(std::move(world)),
        seed(seed_number),
        chance(seed_number + 0x9e3779b97f4a7c15ull * visit),
        truth(draw_truth(file, seed)),
        simulated_arm(file, truth),
        simulated_hand({file.hand.mass, file.hand.damping, file.hand.stiffness,
                        file.player.max_hand_acceleration, file.arm.max_speed},
                       simulated_arm.state().tip, simulated_arm.state().orientation),
        person(file, truth, chance, simulated_arm, simulated_hand),
        simulated_tracker(file, seed, chance),
        simulated_camera(file, chance),
        simulated_right_camera(file, chance, "right-camera"),
        arm_clock(file.clocks.arm),
        tracker_clock(file.clocks.tracker),
        camera_clock(file.clocks.camera),
        graphics_clock(file.clocks.graphics_host),
        step_s(1.0 / file.rate_hz),
        person_interval(std::max(1, static_cast<int>(file.rate_hz / 1000.0 + 0.5))),
        before(simulated_arm.state()) {}

  Instant<TrueTime> step_time(std::int64_t n) const {
    return Instant<TrueTime>::from_seconds(static_cast<double>(n) * step_s);
  }
  Instant<TrueTime> next_tracker_frame() const {
    return Instant<TrueTime>::from_seconds(static_cast<double>(tracker_frames + 1) / file.tracker.rate_hz);
  }

  // Arm state at t between the last two steps.
  SimulatedArm::State arm_state(Instant<TrueTime> t) const {
    const auto& after = simulated_arm.state();
    const double s = 1.0 - to_seconds(step_time(steps) - t) / step_s;
    if (s >= 1.0) return after;
    SimulatedArm::State state;
    state.tip = before.tip + s * (after.tip - before.tip);
    state.velocity = before.velocity + s * (after.velocity - before.velocity);
    state.orientation = before.orientation.slerp(s, after.orientation);
    state.spin = before.spin + s * (after.spin - before.spin);
    return state;
  }

  TrueState state_at(Instant<TrueTime> t) const {
    const auto arm = arm_state(t);
    TrueState state;
    state.X_world_tip = {arm.orientation, arm.tip};
    state.tip_velocity = arm.velocity;
    state.X_world_tip_marker = state.X_world_tip * truth.X_tip_marker;
    state.X_world_camera = person.head().at(t.seconds());
    state.X_world_camera_marker = state.X_world_camera * truth.X_marker_camera.inverse();
    state.X_world_pointer = person.pointer(t.seconds());
    state.theta = simulated_arm.theta_of(arm);
    state.gimbal = simulated_arm.gimbal_of(arm, state.theta);
    state.motor_force = simulated_arm.motor_force();
    return state;
  }

  TrueView view_at(Instant<TrueTime> t) const {
    const auto state = state_at(t);
    TrueView view;
    view.lens = truth.lens;
    view.X_world_camera = state.X_world_camera;
    view.table = truth.table;
    view.wall = truth.wall;
    view.dots = played_since ? disturbed_landmarks(t) : truth.landmarks;
    view.X_world_base = truth.X_world_base;
    view.lengths = truth.lengths;
    view.theta = state.theta;
    view.gimbal = state.gimbal;
    view.X_tip_marker = truth.X_tip_marker;
    view.marker_leds = file.tip_marker.leds;
    if (person.board_in_place()) view.board = truth.X_world_board;
    // As many moments as are averaged leave the noise of one picture.
    view.noise_sd = file.camera.noise_sd * std::sqrt(static_cast<double>(file.camera.blur_steps));
    view.noise_seed = Random(chance + static_cast<std::uint64_t>(t.ns()), "camera/noise").bits();
    return view;
  }

  // What the second camera sees at the same moment.
  TrueView right_of(const TrueView& left) const {
    TrueView view = left;
    view.lens = truth.right_lens;
    view.X_world_camera = left.X_world_camera * truth.X_marker_camera.inverse() * truth.X_marker_right_camera;
    view.noise_seed = Random(left.noise_seed, "right-camera/noise").bits();
    return view;
  }

  // As they are while somebody plays: some have been moved since they were calibrated, some are covered,
  // other ones every second.
  std::vector<Dot> disturbed_landmarks(Instant<TrueTime> t) const {
    auto all = truth.landmarks;
    Random moved(seed, "landmarks/moved");
    const auto order = [](std::size_t count, Random& random) {
      std::vector<std::size_t> list(count);
      for (std::size_t i = 0; i < count; ++i) list[i] = i;
      for (std::size_t i = count; i > 1; --i) std::swap(list[i - 1], list[random.below(i)]);
      return list;
    };
    const auto chosen = order(all.size(), moved);
    for (std::size_t i = 0; i < std::min(all.size(), static_cast<std::size_t>(file.scene.landmarks_moved));
         ++i) {
      Dot& dot = all[chosen[i]];
      const Vector3 along = dot.normal.unitOrthogonal();
      const Quaternion turn(
          Eigen::AngleAxisd(moved.uniform(0.0, 6.283185307179586), dot.normal.normalized()));
      dot.centre += file.scene.landmarks_moved_by * (turn * along);
    }
    const auto covered =
        static_cast<std::size_t>(std::lround(file.scene.landmarks_covered * static_cast<double>(all.size())));
    if (covered == 0) return all;
    Random hidden(seed + static_cast<std::uint64_t>((t - *played_since) / std::chrono::seconds(1)),
                  "landmarks/covered");
    const auto shuffled = order(all.size(), hidden);
    std::vector<Dot> open;
    for (std::size_t i = covered; i < shuffled.size(); ++i) open.push_back(all[shuffled[i]]);
    return open;
  }

  void track(Instant<TrueTime> t) {
    const auto state = state_at(t);
    const auto stamp = tracker_clock.at(t);
    const auto arrival = t + seconds(file.tracker.latency_s);
    const auto add = [&](device::MarkerId id, const std::vector<Vector3>& leds, const Vector3& normal,
                         const auto& pose) {
      tracked.push_back(
          {arrival, simulated_tracker.measure(stamp, {id, &leds, normal, pose.rotation, pose.translation})});
    };
    add(device::MarkerId::tip_marker, file.tip_marker.leds, tip_marker_normal(), state.X_world_tip_marker);
    add(device::MarkerId::camera_marker, file.camera_marker.leds, camera_marker_normal(),
        state.X_world_camera_marker);
    if (state.X_world_pointer)
      add(device::MarkerId::pointer, file.pointer.leds, pointer_normal(), *state.X_world_pointer);
    ++tracker_frames;
    // Nobody takes samples that are half a minute old.
    while (tracked.size() > 8192) tracked.pop_front();
  }

  void expose_due(Instant<TrueTime> until) {
    while (true) {
      const auto moment = static_cast<int>(views.size());
      const auto t = simulated_camera.next_mid_exposure() + simulated_camera.moment_offset(moment);
      if (t > until) return;
      views.push_back(view_at(t));
      if (file.camera.count > 1) right_views.push_back(right_of(views.back()));
      if (moment + 1 < simulated_camera.moments()) continue;
      const auto stamp = camera_clock.at(simulated_camera.next_mid_exposure());
      simulated_camera.expose(stamp, std::move(views));
      if (file.camera.count > 1) simulated_right_camera.expose(stamp, std::move(right_views));
      views.clear(), right_views.clear();
    }
  }

  void advance(Instant<TrueTime> t) {
    while (step_time(steps) < t) {
      if (steps % person_interval == 0) person.update(step_time(steps).seconds());
      before = simulated_arm.state();
      simulated_arm.step(step_s, simulated_hand);
      ++steps;
      const auto reached = step_time(steps);
      while (next_tracker_frame() <= reached) track(next_tracker_frame());
      expose_due(reached);
    }
    if (t > time) time = t;
  }

  // --- devices ---
  device::ArmSample read() override {
    const auto state = arm_state(time);
    const Vector3 theta = simulated_arm.theta_of(state);
    return {.stamp = arm_clock.at(time),
            .joints = simulated_arm.readings(state, theta),
            .gimbal = simulated_arm.gimbal_readings(state, theta),
            .held = simulated_arm.held()};
  }
  void command(const Vector3& force) override { simulated_arm.command(force); }
  void let_go() noexcept override { simulated_arm.command(Vector3::Zero()); }
  std::vector<device::TrackerSample> poll() override {
    std::vector<device::TrackerSample> arrived;
    while (!tracked.empty() && tracked.front().arrival <= time) {
      arrived.push_back(tracked.front().sample);
      arrived.back().waited = time - tracked.front().arrival;
      tracked.pop_front();
    }
    return arrived;
  }
  void move_to(const device::HandTarget& target) override { person.play(target, time.seconds()); }
  Instant<PhysicsClock> now() const override { return physics_time(time); }
  void sleep_until(Instant<PhysicsClock> t) override { advance(true_time(t)); }

  struct Camera : device::CameraDevice {
    Camera(Parts& owner, SimulatedCamera& its_device) : parts(owner), device(its_device) {}
    std::optional<device::CameraImage> poll() override { return take(parts.render); }
    std::optional<device::CameraImage> poll_unseen() override { return take({}); }
    std::optional<device::CameraImage> take(const RenderView& how) {
      const auto shot = device.take(parts.time);
      if (!shot) return std::nullopt;
      return draw_shot(*shot, how);
    }
    Parts& parts;
    SimulatedCamera& device;
  };

  struct Tracked {
    Instant<TrueTime> arrival;
    device::TrackerSample sample;
  };

  config::WorldFile file;
  std::uint64_t seed;
  std::uint64_t chance;  // seed of what a visit draws anew
  Truth truth;
  SimulatedArm simulated_arm;
  SimulatedHand simulated_hand;
  SimPerson person;
  SimulatedTracker simulated_tracker;
  SimulatedCamera simulated_camera, simulated_right_camera;
  DeviceClock<ArmClock> arm_clock;
  DeviceClock<TrackerClock> tracker_clock;
  DeviceClock<CameraClock> camera_clock;
  DeviceClock<GraphicsClock> graphics_clock;
  Camera camera{*this, simulated_camera}, right_camera{*this, simulated_right_camera};
  RenderView render;
  double step_s;
  int person_interval;
  std::int64_t steps = 0, tracker_frames = 0;
  Instant<TrueTime> time;
  SimulatedArm::State before;
  std::deque<Tracked> tracked;
  std::vector<TrueView> views, right_views;  // moments of the frame under exposure
  std::optional<Instant<TrueTime>> played_since;
};

Simulator::Simulator(config::WorldFile file, std::uint64_t seed, std::uint64_t visit)
    : parts_(std::make_unique<Parts>(std::move(file), seed, visit)) {}
Simulator::~Simulator() = default;

Instant<TrueTime> Simulator::now() const { return parts_->time; }
void Simulator::advance_to(Instant<TrueTime> t) { parts_->advance(t); }

device::ArmDevice& Simulator::arm() { return *parts_; }
device::TrackerDevice& Simulator::tracker() { return *parts_; }
device::CameraDevice& Simulator::camera() { return parts_->camera; }
device::CameraDevice* Simulator::right_camera() {
  return parts_->file.camera.count > 1 ? &parts_->right_camera : nullptr;
}
device::HandDevice& Simulator::hand() { return *parts_; }
device::Person& Simulator::person() { return parts_->person; }
Clock<PhysicsClock>& Simulator::physics_clock() { return *parts_; }
void Simulator::set_camera_rate(double rate_hz) {
  parts_->simulated_camera.set_rate(rate_hz);
  parts_->simulated_right_camera.set_rate(rate_hz);
}
std::optional<CameraShot> Simulator::take_shot() { return parts_->simulated_camera.take_exposed(); }
std::optional<CameraShot> Simulator::take_right_shot() {
  return parts_->simulated_right_camera.take_exposed();
}
void Simulator::begin_play() {
  if (!parts_->played_since) parts_->played_since = parts_->time;
}
void Simulator::set_renderer(RenderView render) { parts_->render = std::move(render); }

const config::WorldFile& Simulator::file() const { return parts_->file; }
std::uint64_t Simulator::seed() const { return parts_->seed; }
const Truth& Simulator::truth() const { return parts_->truth; }
TrueState Simulator::true_state() const { return parts_->state_at(parts_->time); }
TrueView Simulator::true_view() const { return parts_->view_at(parts_->time); }
Pose<World, CameraOptical> Simulator::true_camera_at(Instant<TrueTime> t) const {
  return parts_->person.head().at(t.seconds());
}
bool Simulator::board_in_place() const { return parts_->person.board_in_place(); }

const DeviceClock<ArmClock>& Simulator::arm_clock() const { return parts_->arm_clock; }
const DeviceClock<TrackerClock>& Simulator::tracker_clock() const { return parts_->tracker_clock; }
const DeviceClock<CameraClock>& Simulator::camera_clock() const { return parts_->camera_clock; }
const DeviceClock<GraphicsClock>& Simulator::graphics_clock() const { return parts_->graphics_clock; }

}  // namespace palpate::sim
