#include "palpate/record/session/physics_ticks.h"

#include <algorithm>
#include <cstddef>

namespace palpate::record::session {
namespace {

template <std::size_t N>
std::uint8_t copy_inputs(const InputTrace& trace, std::array<std::uint64_t, N>& to) noexcept {
  const auto values = trace.values();
  std::copy(values.begin(), values.end(), to.begin());
  return static_cast<std::uint8_t>(values.size());
}

template <typename Packed>
TickInputs packed_inputs(const Packed& p) {
  return {p.exact != 0, {p.inputs.begin(), p.inputs.begin() + p.input_count}};
}

}  // namespace

void HapticTickRing::push(const haptics::HapticTick& tick, const InputTrace& trace) noexcept {
  Packed p;
  p.number = tick.number;
  p.begun_ns = tick.begun.ns();
  p.stamp_ns = tick.sample.stamp.ns();
  p.waited_ns = tick.sample.waited.count();
  const Vector3 held = tick.sample.held.value_or(Vector3::Zero());
  double* to = p.numbers.data();
  for (const Vector3* v : {&tick.sample.gimbal, &tick.sample.withheld, &held, &tick.tip, &tick.continuous,
                           &tick.impact, &tick.commanded})
    for (int i = 0; i < 3; ++i) *to++ = (*v)[i];
  *to++ = tick.speed;
  for (const double angle : tick.sample.joints) *to++ = angle;
  p.buttons = tick.sample.buttons;
  p.joints = static_cast<std::uint8_t>(tick.sample.joints.size());
  p.connected = tick.sample.connected;
  p.have_held = tick.sample.held.has_value();
  p.state = static_cast<std::uint8_t>(tick.state);
  p.fault = static_cast<std::uint8_t>(tick.fault);
  p.culprit = static_cast<std::uint8_t>(tick.culprit);
  p.input_count = copy_inputs(trace, p.inputs);
  p.exact = trace.exact();
  ring_.push(p);
}

std::optional<RecordedHapticTick> HapticTickRing::read(std::uint64_t k) const {
  Packed p;
  if (!ring_.read(k, p)) return std::nullopt;
  const auto at = [&p](std::size_t i) { return Vector3(p.numbers[i], p.numbers[i + 1], p.numbers[i + 2]); };
  RecordedHapticTick r;
  r.tick.number = p.number;
  r.tick.begun = {Duration(p.begun_ns)};
  r.tick.sample.stamp = {Duration(p.stamp_ns)};
  r.tick.sample.waited = Duration(p.waited_ns);
  r.tick.sample.joints = Eigen::Map<const Eigen::VectorXd>(p.numbers.data() + 22, p.joints);
  r.tick.sample.gimbal = at(0);
  r.tick.sample.withheld = at(3);
  if (p.have_held != 0) r.tick.sample.held = at(6);
  r.tick.sample.connected = p.connected != 0;
  r.tick.sample.buttons = p.buttons;
  r.tick.tip = at(9);
  r.tick.continuous = at(12);
  r.tick.impact = at(15);
  r.tick.commanded = at(18);
  r.tick.speed = p.numbers[21];
  r.tick.state = static_cast<haptics::ForceState>(p.state);
  r.tick.fault = static_cast<haptics::ForceFault>(p.fault);
  r.tick.culprit = static_cast<haptics::Guest>(p.culprit);
  r.inputs = packed_inputs(p);
  return r;
}

void StepRing::control(scene::Control control) noexcept {
  if (next_.control_count < kMostControls)
    next_.controls[next_.control_count++] = control;
  else
    ++next_.controls_left_out;
}

void StepRing::push(Instant<PhysicsClock> now, const scene::SceneState* state,
                    const InputTrace& trace) noexcept {
  next_.now_ns = now.ns();
  next_.input_count = copy_inputs(trace, next_.inputs);
  next_.exact = trace.exact();
  next_.moved = state != nullptr;
  if (state != nullptr)
    next_.state = *state;
  else
    next_.state.body_count = 0;
  ring_.push(next_);
  next_.control_count = 0;
  next_.controls_left_out = 0;
}

std::optional<RecordedStep> StepRing::read(std::uint64_t k) const {
  Room<Packed> room;
  Packed& p = room.value();
  if (!ring_.read(k, p)) return std::nullopt;
  RecordedStep r;
  r.number = k + 1;
  r.now = {Duration(p.now_ns)};
  r.controls.assign(p.controls.begin(), p.controls.begin() + p.control_count);
  r.controls_left_out = p.controls_left_out;
  r.inputs = packed_inputs(p);
  if (p.moved != 0) r.state = p.state;
  return r;
}

}  // namespace palpate::record::session
