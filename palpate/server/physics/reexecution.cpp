#include "palpate/server/physics/reexecution.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <mutex>
#include <optional>
#include <thread>

#include "palpate/record/session/tick_messages.h"
#include "palpate/scene/mesh_asset.h"
#include "palpate/server/physics/internal/recorded_arm.h"
#include "palpate/server/physics/internal/recorded_ticks.h"
#include "palpate/server/physics/physics_side.h"
#include "palpate/time/input_playback.h"
#include "palpate/time/input_trace.h"
#include "palpate/time/thread_clock.h"
#include "palpate/transport/messages.h"

namespace palpate::server::physics {
namespace {

bool same_bits(const Vector3& a, const Vector3& b) {
  for (int i = 0; i < 3; ++i)
    if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i])) return false;
  return true;
}

std::string words_of(const Vector3& v) {
  return fmt::format("({:.17g}, {:.17g}, {:.17g})", v.x(), v.y(), v.z());
}

// One loop's record may go on for so long after the other's, where a file breaks off between them.
constexpr Duration kBrokenOff = std::chrono::milliseconds(100);

// What differs between a tick then and now; empty: nothing.
std::string difference(const haptics::HapticTick& then, const haptics::HapticTick& now) {
  const auto differs = [](const char* what, const Vector3& a, const Vector3& b) {
    return fmt::format("{} was {}, is {}", what, words_of(a), words_of(b));
  };
  if (!same_bits(then.tip, now.tip)) return differs("tip, m,", then.tip, now.tip);
  if (!same_bits(then.continuous, now.continuous))
    return differs("continuous force, N,", then.continuous, now.continuous);
  if (!same_bits(then.impact, now.impact)) return differs("impact, N,", then.impact, now.impact);
  if (!same_bits(then.commanded, now.commanded))
    return differs("commanded force, N,", then.commanded, now.commanded);
  if (then.state != now.state || then.fault != now.fault)
    return fmt::format("forces were {}, are {}", device::condition_text({then.state, then.fault}),
                       device::condition_text({now.state, now.fault}));
  return {};
}

// Both loops of one side, each in a thread, until their ticks are through or one cannot go on.
class Execution {
 public:
  Execution(const RecordedTicks& recorded, PhysicsSide& side, RecordedArm& arm, InputPlayback& playback)
      : recorded_(recorded), side_(side), arm_(arm), playback_(playback) {
    result_.recorded_ticks = recorded.samples.size();
    result_.recorded_steps = recorded.steps.size();
    result_.lost = recorded.lost;
    if (recorded.samples.size() > 0) ticks_end_ = sample_time(recorded.samples.size() - 1);
    if (recorded.steps.size() > 0)
      if (const auto last = recorded.step(recorded.steps.size() - 1)) steps_end_ = last->now;
  }

  Reexecution run() {
    std::thread haptic([this] {
      while (!stop_ && haptic_tick()) {
      }
      playback_.end_loop();
    });
    while (!stop_ && physics_step()) {
    }
    playback_.end_loop();
    haptic.join();
    return result_;
  }

 private:
  // False where there is no further one, or it cannot be executed.
  bool haptic_tick();
  bool physics_step();
  void compare(const haptics::HapticTick& then, const haptics::HapticTick& now);
  void compare_state(std::uint64_t step);
  // The first of all: by ticks' times both loops' differences have an order, which threads do not tell.
  void differ(Instant<PhysicsClock> when, std::string words) {
    const std::lock_guard lock(mutex_);
    if (!result_.first_difference.empty() && when >= first_) return;
    first_ = when;
    result_.first_difference = std::move(words);
  }
  bool give_up(Instant<PhysicsClock> when, std::string words) {
    differ(when, std::move(words));
    stop_ = true;
    return false;
  }

  // Where a file breaks off, the last of one loop took over what the other did later: of them nothing is known.
  bool beyond(Instant<PhysicsClock> when) const {
    return !stop_ && ticks_end_ && steps_end_ && when + kBrokenOff >= std::max(*ticks_end_, *steps_end_);
  }
  std::optional<Instant<PhysicsClock>> sample_time(std::size_t i) const {
    const auto sample = record::session::decode_sample(recorded_.samples[i]);
    return sample ? std::optional(sample->tick.begun) : std::nullopt;
  }
  bool end_ticks() {
    result_.ticks_beyond = recorded_.samples.size() - result_.ticks;
    return false;
  }
  bool end_steps() {
    result_.steps_beyond = recorded_.steps.size() - result_.steps;
    return false;
  }

  const RecordedTicks& recorded_;
  PhysicsSide& side_;
  RecordedArm& arm_;
  std::optional<Instant<PhysicsClock>> ticks_end_, steps_end_;
  InputPlayback& playback_;
  std::mutex mutex_;  // first_, first_difference
  Instant<PhysicsClock> first_, last_tick_, last_step_;
  Reexecution result_;
  std::uint64_t states_ = 0;
  std::atomic<bool> stop_{false};
};

bool Execution::haptic_tick() {
  const std::uint64_t i = result_.ticks;
  if (i == recorded_.samples.size()) return false;
  if (i >= recorded_.forces.size())
    if (const auto when = sample_time(i); when && beyond(*when)) return end_ticks();
  const auto recorded = recorded_.tick(i);
  if (!recorded) return give_up(last_tick_, fmt::format("tick {}: {}", i + 1, recorded.error().message));
  const haptics::HapticTick& then = recorded->tick;
  last_tick_ = then.begun;
  if (then.number != i + 1)
    return give_up(then.begun,
                   fmt::format("tick {} is not in the recording; {} follows", i + 1, then.number));
  if (!recorded->inputs.exact)
    return give_up(then.begun, fmt::format("tick {}: not all that it learned was recorded", i + 1));
  arm_.set(then.sample);
  InputTrace trace;
  trace.play(recorded->inputs.values, playback_);
  haptics::HapticTick now;
  {
    const InputTrace::Scope scope(&trace);
    side_.server().haptic_tick(then.begun, &now);
  }
  if (playback_.failed() && beyond(then.begun)) return end_ticks();
  if (playback_.failed() || stop_)
    return give_up(
        then.begun,
        fmt::format("tick {}: a value that it took over from the physics loop never comes", i + 1));
  if (!trace.exact())
    return give_up(then.begun, fmt::format("tick {}: it learns other things than it did ({} then)", i + 1,
                                           recorded->inputs.values.size()));
  compare(then, now);
  ++result_.ticks;
  return true;
}

void Execution::compare(const haptics::HapticTick& then, const haptics::HapticTick& now) {
  const std::string words = difference(then, now);
  if (words.empty()) return;
  ++result_.different_forces;
  const double by = (then.commanded - now.commanded).norm();
  result_.largest_force_difference_n = std::max(result_.largest_force_difference_n, by);
  differ(then.begun, fmt::format("tick {}: {}", then.number, words));
}

bool Execution::physics_step() {
  const std::uint64_t i = result_.steps;
  if (i == recorded_.steps.size()) return false;
  const auto recorded = recorded_.step(i);
  if (!recorded) return give_up(last_step_, fmt::format("step {}: {}", i + 1, recorded.error().message));
  last_step_ = recorded->now;
  if (recorded->number != i + 1)
    return give_up(recorded->now,
                   fmt::format("step {} is not in the recording; {} follows", i + 1, recorded->number));
  if (!recorded->inputs.exact || recorded->controls_left_out > 0)
    return give_up(recorded->now, fmt::format("step {}: not all that it learned was recorded", i + 1));
  InputTrace trace;
  trace.play(recorded->inputs.values, playback_);
  const std::uint64_t moved = side_.server().newest().tick;
  {
    const InputTrace::Scope scope(&trace);
    for (const auto control : recorded->controls) side_.server().control(control);
    side_.server().physics_tick(recorded->now);
  }
  if (playback_.failed() && beyond(recorded->now)) return end_steps();
  if (playback_.failed() || stop_)
    return give_up(recorded->now,
                   fmt::format("step {}: a value that it took over from the haptic loop never comes", i + 1));
  if (!trace.exact())
    return give_up(recorded->now, fmt::format("step {}: it learns other things than it did ({} then)", i + 1,
                                              recorded->inputs.values.size()));
  if (side_.server().newest().tick != moved) {
    if (states_ == recorded_.states.size() && beyond(recorded->now)) return end_steps();
    compare_state(i + 1);
  }
  ++result_.steps;
  return true;
}

void Execution::compare_state(std::uint64_t step) {
  const bool same = states_ < recorded_.states.size() &&
                    recorded_.states[states_] == digest(transport::encode(side_.server().newest()));
  ++states_;
  if (same) return;
  ++result_.different_states;
  differ(last_step_, fmt::format("step {}: it leaves the world in another state", step));
}

}  // namespace

Json json_of(const Reexecution& result) {
  return {{"same", result.same()},
          {"ticks", result.ticks},
          {"steps", result.steps},
          {"recorded_ticks", result.recorded_ticks},
          {"recorded_steps", result.recorded_steps},
          {"ticks_beyond", result.ticks_beyond},
          {"steps_beyond", result.steps_beyond},
          {"different_forces", result.different_forces},
          {"different_states", result.different_states},
          {"largest_force_difference_n", result.largest_force_difference_n},
          {"first_difference", result.first_difference},
          {"lost", result.lost}};
}

Expected<Reexecution> execute_again(const ReexecutionOptions& options) {
  auto recorded = RecordedTicks::read(options.recording);
  if (!recorded) return tl::unexpected(recorded.error());
  if (auto found = scene::find_mesh_asset(recorded->scene, options.mesh, true); !found)
    return tl::unexpected(found.error());
  RecordedArm* arm = nullptr;
  PhysicsSetup setup;
  setup.rig = recorded->rig;
  setup.applications = options.applications;
  setup.scene = recorded->scene;
  setup.run = recorded->setup.run;
  setup.run.keeps_files = false;  // what a person has learned, for one, counts once
  setup.physics_hz = recorded->setup.physics_hz;
  setup.haptic_hz = recorded->setup.haptic_hz;
  setup.armed = recorded->setup.armed;
  setup.extra_force_delay = recorded->setup.extra_force_delay;
  setup.arm.uri = "recorded";
  device::ArmOpener opener;
  opener.form = "recorded";
  opener.open = [&](const device::ArmRequest&) -> Expected<std::unique_ptr<device::OpenedArm>> {
    auto opened = std::make_unique<OpenedRecordedArm>(recorded->setup.arm, recorded->setup.torque_limits);
    arm = &opened->device();
    return std::unique_ptr<device::OpenedArm>(std::move(opened));
  };
  setup.drivers.add(device::Driver{.scheme = "recorded", .summary = "the arm of a recording", .arm = opener});

  // What is made takes part in the playback from its first write on.
  InputPlayback playback(2);
  InputTrace making;
  making.play({}, playback);
  const InputTrace::Scope scope(&making);
  const MachineThreadClock clock;
  auto side = PhysicsSide::open(setup, recorded->setup.guests_timed ? &clock : nullptr);
  if (!side) return tl::unexpected(side.error());
  return Execution(*recorded, **side, *arm, playback).run();
}

}  // namespace palpate::server::physics
