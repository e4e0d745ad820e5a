// Messages as bytes: values to wire. The other way: messages_decode.cpp, which refuses texts with control
// characters; ours are made fit for it here, wherever their words came from.
#include <palpate.pb.h>

#include <algorithm>
#include <bit>

#include "palpate/core/text.h"
#include "palpate/transport/internal/message_arena.h"
#include "palpate/transport/internal/wire_forces.h"
#include "palpate/transport/internal/wire_health.h"
#include "palpate/transport/messages.h"

namespace palpate::transport {

namespace {

using Doubles = google::protobuf::RepeatedField<double>;

template <std::size_t N>
void put(Doubles* field, const std::array<double, N>& values) {
  field->Reserve(static_cast<int>(N));
  for (double value : values) field->Add(value);
}

std::array<double, 3> plain(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

void put(wire::WorldState* out, const scene::SceneState& state) {
  out->set_time_ns(state.time.ns());
  out->set_tick(state.tick);
  for (int i = 0; i < std::clamp(state.body_count, 0, scene::SceneState::kBodies); ++i) {
    const scene::BodyState& body = state.bodies[static_cast<std::size_t>(i)];
    wire::BodyState* to = out->add_bodies();
    put(to->mutable_position_m(), body.position);
    put(to->mutable_orientation_wxyz(), body.orientation);
    put(to->mutable_velocity_m_per_s(), body.velocity);
    put(to->mutable_angular_velocity_rad_per_s(), body.angular_velocity);
    to->set_jumps(body.jumps);
    to->set_visible(body.visible != 0);
  }
  for (std::int32_t counter : state.counters) out->add_counters(counter);
  put(out->mutable_impact_force_n(), state.impact.force);
  out->set_impact_share(state.impact.share);
  put(out->mutable_impact_point_m(), state.impact.point);
  put(out->mutable_continuous_force_n(), state.continuous.force);
  out->set_touching(state.continuous.touching != 0);
  put(out->mutable_touching_point_m(), state.continuous.point);
}

void put(wire::SceneDescription* out, const scene::SceneDescription& scene) {
  out->set_application(one_line(scene.application));
  for (const scene::SceneSurface& surface : scene.surfaces) {
    wire::SceneSurface* to = out->add_surfaces();
    to->set_name(one_line(surface.name));
    for (const Vector3& corner : surface.corners) {
      for (double x : plain(corner)) to->add_corners_m(x);
    }
  }
  for (const Vector3& tip : scene.arm_tips)
    for (double x : plain(tip)) out->add_arm_tips_m(x);
  put(out->mutable_gravity_m_per_s2(), plain(scene.gravity));
  put(out->mutable_carried_offset_m(), plain(scene.carried_offset));
  for (const scene::BodyDescription& body : scene.bodies) {
    wire::BodyDescription* to = out->add_bodies();
    to->set_name(one_line(body.name));
    to->set_mass_kg(body.mass);
  }
  if (scene.mesh) {
    wire::MeshAsset* mesh = out->mutable_mesh();
    mesh->set_file(scene.mesh->file);
    mesh->set_hash(scene.mesh->hash);
    mesh->set_metres_per_unit(scene.mesh->metres_per_unit);
  }
  if (scene.settings.version != 0) {
    out->mutable_settings()->set_version(scene.settings.version);
    out->mutable_settings()->set_content(scene.settings.bytes);
  }
  out->set_shape_vertices(static_cast<std::uint32_t>(scene.shape_vertices));
}

void put(wire::ClientFigures* out, const ClientFigures& figures) {
  out->set_frames(figures.frames);
  out->set_late(figures.late);
  out->set_lost(figures.lost);
  out->set_rate_hz(figures.rate_hz);
  out->set_round_trip_median_us(figures.round_trip_median_us);
  out->set_round_trip_p99_us(figures.round_trip_p99_us);
  out->set_clock_offset_s(figures.clock_offset_s);
  out->set_clock_uncertainty_us(figures.clock_uncertainty_us);
  for (const auto& condition : figures.conditions) {
    if (out->conditions_size() == kMaxConditions) break;
    auto* told = out->add_conditions();
    told->set_code(to_wire(kWireHealthCodes, condition.code));
    told->set_severity(to_wire(kWireSeverities, device::severity_of(condition.code)));
    told->set_age_s(condition.age_s);
    told->set_words(excerpt(condition.words, kMaxConditionBytes - 3));  // and "..."
  }
}

wire::Role wire_role(Role role) { return static_cast<wire::Role>(static_cast<int>(role) + 1); }

void put(wire::LoopStatus* out, const LoopStatus& loop) {
  out->set_name(one_line(loop.name));
  out->set_rate_hz(loop.rate_hz);
  out->set_ticks(loop.ticks);
  out->set_overruns(loop.overruns);
  out->set_missed(loop.missed);
  out->set_late_p50_us(loop.late_p50_us);
  out->set_late_p99_us(loop.late_p99_us);
  out->set_late_max_us(loop.late_max_us);
  out->set_busy_p99_us(loop.busy_p99_us);
  for (const std::uint64_t count : loop.late_octaves) out->add_late_octaves(count);
  if (!loop.forces) return;
  out->set_condition(one_line(loop.forces_text()));
  out->set_force_state(to_wire(kWireForceStates, loop.forces->state));
  out->set_force_fault(to_wire(kWireForceFaults, loop.forces->fault));
  out->set_culprit(one_line(loop.culprit));
  out->set_peak_n(loop.peak_n);
  out->set_continuous_n(loop.continuous_n);
  out->set_trips(loop.trips);
}

void put(wire::ToPhysics& out, const Hello& message) {
  out.mutable_hello()->set_client(message.client);
  out.mutable_hello()->set_known_session(message.known_session);
  out.mutable_hello()->set_name(one_line(message.name));
  if (message.figures) put(out.mutable_hello()->mutable_figures(), *message.figures);
}
void put(wire::ToPhysics& out, const StatusRequest& message) {
  out.mutable_status_request()->set_number(message.number);
}
void put(wire::ToPhysics& out, const StateRequest& message) {
  out.mutable_state_request()->set_number(message.number);
  out.mutable_state_request()->set_time_ns(message.time.ns());
  out.mutable_state_request()->set_shape(message.shape);
}
void put(wire::ToPhysics& out, const SyncRequest& message) {
  out.mutable_sync_request()->set_number(message.number);
}
void put(wire::ToPhysics& out, const ControlCall& message) {
  out.mutable_control_call()->set_client(message.client);
  out.mutable_control_call()->set_number(message.number);
  out.mutable_control_call()->set_control(static_cast<wire::Control>(message.control));
}
void put(wire::ToPhysics& out, const Subscribe& message) {
  out.mutable_subscribe()->set_rate_hz(static_cast<std::uint32_t>(message.rate_hz));
}
void put(wire::ToGraphics& out, const Welcome& message) {
  out.mutable_welcome()->set_session(message.session);
  if (message.scene) put(out.mutable_welcome()->mutable_scene(), *message.scene);
  out.mutable_welcome()->set_states(message.states);
  out.mutable_welcome()->set_role(wire_role(message.role));
}
void put(wire::ToGraphics& out, const StateReply& message) {
  wire::StateReply* to = out.mutable_state_reply();
  to->set_number(message.number);
  to->set_asked_time_ns(message.asked.ns());
  to->set_kind(static_cast<wire::AnswerKind>(message.answer.kind));
  to->set_extrapolated_ns(message.answer.extrapolated_by.count());
  put(to->mutable_state(), message.answer.state);
  if (!message.shape) return;
  to->mutable_shape()->set_time_ns(message.shape->time.ns());
  to->mutable_shape()->set_vertices(static_cast<std::uint32_t>(message.shape->vertices()));
}
void put(wire::ToGraphics& out, const SyncReply& message) {
  out.mutable_sync_reply()->set_number(message.number);
  out.mutable_sync_reply()->set_received_ns(message.t2.ns());
  out.mutable_sync_reply()->set_sent_ns(message.t3.ns());
}
void put(wire::ToGraphics& out, const ControlReply& message) {
  out.mutable_control_reply()->set_number(message.number);
  out.mutable_control_reply()->set_refusal(excerpt(message.refusal, kMaxReasonBytes - 3));
}
void put(wire::StatusReply* to, const ServerStatus& status) {
  to->set_uptime_s(status.uptime_s);
  to->set_application(one_line(status.application));
  to->set_failure(excerpt(status.failure, kMaxReasonBytes - 3));
  for (const LoopStatus& loop : status.loops) put(to->add_loops(), loop);
  for (const ClientStatus& client : status.clients) {
    wire::ClientStatus* one = to->add_clients();
    one->set_name(one_line(client.name));
    one->set_role(wire_role(client.role));
    put(one->mutable_figures(), client.figures);
  }
  to->set_requests(status.requests);
  to->set_syncs(status.syncs);
  to->set_controls(status.controls);
  to->set_rejected(status.rejected);
  to->set_turned_away(status.rejected_connections);
  to->set_unsent(status.unsent);
  to->set_published(status.published);
  if (!status.recording) return;
  to->mutable_recording()->set_seconds(status.recording->seconds);
  to->mutable_recording()->set_dropped(status.recording->dropped);
  to->mutable_recording()->set_ended(status.recording->ended);
}
void put(wire::ToGraphics& out, const StatusReply& message) {
  out.mutable_status_reply()->set_number(message.number);
  put(out.mutable_status_reply(), message.status);
}
void put(wire::ToGraphics& out, const Refusal& message) {
  out.mutable_refusal()->set_reason(excerpt(message.reason, kMaxReasonBytes - 3));
}

template <typename Wire, typename Message>
std::string encode_as(const Message& message) {
  MessageArena arena;
  Wire& out = arena.make<Wire>();
  out.set_protocol(kProtocol);
  std::visit([&](const auto& body) { put(out, body); }, message);
  return out.SerializeAsString();
}

template <typename Wire, typename Part>
std::string encode_part(const Part& part) {
  MessageArena arena;
  Wire& out = arena.make<Wire>();
  put(&out, part);
  return out.SerializeAsString();
}

}  // namespace

std::string encode(const ClientMessage& message) { return encode_as<wire::ToPhysics>(message); }
std::string encode(const ServerMessage& message) { return encode_as<wire::ToGraphics>(message); }
std::string encode(const scene::SceneState& state) { return encode_part<wire::WorldState>(state); }
std::string encode(const ServerStatus& status) { return encode_part<wire::StatusReply>(status); }
std::string encode(const scene::SceneDescription& scene) {
  return encode_part<wire::SceneDescription>(scene);
}

std::shared_ptr<const scene::Shape> shape_of(const ServerMessage& message) {
  const auto* reply = std::get_if<StateReply>(&message);
  return reply == nullptr ? nullptr : reply->shape;
}

std::vector<std::string_view> shape_pieces(const scene::Shape& shape, std::size_t piece_bytes) {
  static_assert(std::endian::native == std::endian::little, "shapes travel in this machine's byte order");
  std::string_view rest(reinterpret_cast<const char*>(shape.values.data()),
                        shape.values.size() * sizeof(float));
  std::vector<std::string_view> pieces;
  while (!rest.empty()) {
    pieces.push_back(rest.substr(0, piece_bytes));
    rest.remove_prefix(pieces.back().size());
  }
  return pieces;
}

}  // namespace palpate::transport
