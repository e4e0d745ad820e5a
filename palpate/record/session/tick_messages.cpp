#include "palpate/record/session/tick_messages.h"

#include <algorithm>
#include <utility>

#include "palpate/record/session/internal/message_parts.h"
#include "palpate/transport/wire_numbers.h"

namespace palpate::record::session {
namespace {

using google::protobuf::RepeatedField;

template <typename Wire>
void put_inputs(Wire& out, const TickInputs& inputs) {
  for (const auto value : inputs.values) out.add_inputs(value);
  out.set_inputs_exact(inputs.exact);
}

template <typename Wire>
TickInputs inputs_of(const Wire& in) {
  return {in.inputs_exact(), {in.inputs().begin(), in.inputs().end()}};
}

recording::Guest wire_guest(haptics::Guest guest) {
  return static_cast<recording::Guest>(static_cast<int>(guest));
}

}  // namespace

std::string encode_sample(const RecordedHapticTick& recorded) {
  const haptics::HapticTick& tick = recorded.tick;
  recording::ArmSample out;
  out.set_tick(tick.number);
  out.set_begun_ns(tick.begun.ns());
  out.set_stamp_ns(tick.sample.stamp.ns());
  out.set_waited_ns(tick.sample.waited.count());
  for (const double angle : tick.sample.joints) out.add_joints_rad(angle);
  put(out.mutable_gimbal_rad(), tick.sample.gimbal);
  out.set_connected(tick.sample.connected);
  out.set_buttons(tick.sample.buttons);
  put(out.mutable_withheld_n_s(), tick.sample.withheld);
  if (tick.sample.held) put(out.mutable_held_n(), *tick.sample.held);
  put_inputs(out, recorded.inputs);
  return out.SerializeAsString();
}

std::string encode_force(const haptics::HapticTick& tick) {
  recording::ArmForce out;
  out.set_tick(tick.number);
  put(out.mutable_tip_m(), tick.tip);
  out.set_speed_m_s(tick.speed);
  put(out.mutable_continuous_n(), tick.continuous);
  put(out.mutable_impact_n(), tick.impact);
  put(out.mutable_commanded_n(), tick.commanded);
  out.set_state(static_cast<wire::ForceState>(transport::wire_number(tick.state)));
  out.set_fault(static_cast<wire::ForceFault>(transport::wire_number(tick.fault)));
  out.set_culprit(wire_guest(tick.culprit));
  return out.SerializeAsString();
}

std::string encode_step(const RecordedStep& step) {
  recording::PhysicsStep out;
  out.set_number(step.number);
  out.set_now_ns(step.now.ns());
  for (const auto control : step.controls)
    out.add_controls(static_cast<wire::Control>(transport::wire_number(control)));
  out.set_controls_left_out(step.controls_left_out);
  put_inputs(out, step.inputs);
  return out.SerializeAsString();
}

// What is no number in a reading stays none: so the tick had it.
Expected<RecordedHapticTick> decode_sample(std::string_view bytes) {
  const auto in = parse<recording::ArmSample>(bytes, "an ArmSample");
  if (!in) return tl::unexpected(in.error());
  if (in->joints_rad_size() > device::kMostJoints)
    return refused("an ArmSample has {} joints; at most {} are expected", in->joints_rad_size(),
                   device::kMostJoints);
  RecordedHapticTick recorded;
  haptics::HapticTick& tick = recorded.tick;
  tick.number = in->tick();
  tick.begun = {Duration(in->begun_ns())};
  tick.sample.stamp = {Duration(in->stamp_ns())};
  tick.sample.waited = Duration(in->waited_ns());
  tick.sample.joints = Eigen::Map<const Eigen::VectorXd>(in->joints_rad().data(), in->joints_rad_size());
  tick.sample.gimbal = vector_of(in->gimbal_rad());
  tick.sample.connected = in->connected();
  tick.sample.buttons = in->buttons();
  tick.sample.withheld = vector_of(in->withheld_n_s());
  if (in->has_held_n()) tick.sample.held = vector_of(in->held_n());
  recorded.inputs = inputs_of(*in);
  return recorded;
}

Expected<void> decode_force(std::string_view bytes, haptics::HapticTick& tick) {
  const auto in = parse<recording::ArmForce>(bytes, "an ArmForce");
  if (!in) return tl::unexpected(in.error());
  const auto state = transport::force_state_of(in->state());
  const auto fault = transport::force_fault_of(in->fault());
  if (!state || !fault || !recording::Guest_IsValid(in->culprit()))
    return refused("an ArmForce has a state, a fault or a culprit that means nothing here");
  tick.number = in->tick();
  tick.tip = vector_of(in->tip_m());
  tick.speed = in->speed_m_s();
  tick.continuous = vector_of(in->continuous_n());
  tick.impact = vector_of(in->impact_n());
  tick.commanded = vector_of(in->commanded_n());
  tick.state = *state;
  tick.fault = *fault;
  tick.culprit = static_cast<haptics::Guest>(in->culprit());
  return {};
}

Expected<RecordedStep> decode_step(std::string_view bytes) {
  const auto in = parse<recording::PhysicsStep>(bytes, "a PhysicsStep");
  if (!in) return tl::unexpected(in.error());
  RecordedStep step;
  step.number = in->number();
  step.now = {Duration(in->now_ns())};
  for (const int number : in->controls()) {
    const auto control = transport::control_of(number);
    if (!control) return refused("a PhysicsStep has the wish {}, which means nothing here", number);
    step.controls.push_back(*control);
  }
  step.controls_left_out = in->controls_left_out();
  step.inputs = inputs_of(*in);
  return step;
}

}  // namespace palpate::record::session
