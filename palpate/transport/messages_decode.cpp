// Bytes as messages: wire to values, everything checked before it is believed.
#include <google/protobuf/stubs/logging.h>
#include <palpate.pb.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/scene/mesh_asset.h"
#include "palpate/transport/internal/message_arena.h"
#include "palpate/transport/internal/wire_forces.h"
#include "palpate/transport/internal/wire_health.h"
#include "palpate/transport/messages.h"

namespace palpate::transport {

namespace {

using Doubles = google::protobuf::RepeatedField<double>;

// Instants further from zero than this (36 years) could overflow where a clock's lead is reckoned from four of them.
constexpr std::int64_t kMaxTimeNs = std::int64_t{1} << 60;
constexpr int kMaxLoops = 8, kMaxOctaves = 40, kMaxClientsTold = 64;
constexpr double kUnitTolerance = 1e-3;  // of a quaternion's norm: a sanity check, not a normalisation

// Reads one message; the first thing found wrong stays as the reason.
class Check {
 public:
  bool good() const { return reason_.empty(); }
  const std::string& reason() const { return reason_; }
  void fail(std::string reason) {
    if (good()) reason_ = std::move(reason);
  }

  void require(bool condition, const char* field, const char* expectation) {
    if (!condition) fail(fmt::format("{} must be {}", field, expectation));
  }
  template <typename C>
  Instant<C> time(std::int64_t ns, const char* field) {
    require(ns > -kMaxTimeNs && ns < kMaxTimeNs, field, "within 36 years of the clock's zero");
    return good() ? Instant<C>{Duration(ns)} : Instant<C>{};
  }
  std::uint64_t number(std::uint64_t value, const char* field) {
    require(value != 0, field, "1 or more");
    return value;
  }
  double finite(double value, const char* field) {
    require(std::isfinite(value), field, "a finite number");
    return value;
  }
  double positive(double value, const char* field) {
    require(std::isfinite(value) && value > 0.0, field, "finite and above 0");
    return value;
  }
  double not_negative(double value, const char* field) {
    require(std::isfinite(value) && value >= 0.0, field, "finite and 0 or more");
    return value;
  }
  double within(double value, double low, double high, const char* field) {
    if (!(value >= low && value <= high)) fail(fmt::format("{} must be {:g} to {:g}", field, low, high));
    return good() ? value : 0.0;
  }
  double fraction(double value, const char* field) {
    require(value >= 0.0 && value <= 1.0, field, "between 0 and 1");
    return value;
  }
  template <std::size_t N>
  std::array<double, N> numbers(const Doubles& values, const char* field) {
    std::array<double, N> result{};
    if (values.size() != static_cast<int>(N)) {
      fail(fmt::format("{} must be {} numbers, not {}", field, N, values.size()));
      return result;
    }
    for (std::size_t i = 0; i < N; ++i) result[i] = finite(values[static_cast<int>(i)], field);
    return result;
  }
  Vector3 vector(const Doubles& values, const char* field) {
    const auto v = numbers<3>(values, field);
    return {v[0], v[1], v[2]};
  }
  std::string text(const std::string& value, std::size_t limit, const char* field) {
    if (value.size() > limit)
      fail(fmt::format("{} must be at most {} bytes, not {}", field, limit, value.size()));
    // It will be shown on terminals.
    if (good() && !is_plain(value))
      fail(fmt::format("{} must be without control characters, not '{}'", field, excerpt(value)));
    return good() ? value : std::string();
  }
  std::string bytes(const std::string& value, std::size_t limit, const char* field) {
    if (value.size() > limit)
      fail(fmt::format("{} must be at most {} bytes, not {}", field, limit, value.size()));
    return good() ? value : std::string();
  }
  void count(int value, int limit, const char* field) {
    if (value > limit) fail(fmt::format("{} must be at most {}, not {}", field, limit, value));
  }

 private:
  std::string reason_;
};

scene::BodyState read(Check& check, const wire::BodyState& in) {
  scene::BodyState body;
  body.position = check.numbers<3>(in.position_m(), "position_m");
  body.orientation = check.numbers<4>(in.orientation_wxyz(), "orientation_wxyz");
  double square = 0.0;
  for (double q : body.orientation) square += q * q;
  check.require(std::abs(std::sqrt(square) - 1.0) < kUnitTolerance, "orientation_wxyz", "a unit quaternion");
  body.velocity = check.numbers<3>(in.velocity_m_per_s(), "velocity_m_per_s");
  body.angular_velocity = check.numbers<3>(in.angular_velocity_rad_per_s(), "angular_velocity_rad_per_s");
  body.jumps = in.jumps();
  body.visible = in.visible() ? 1 : 0;
  return body;
}

scene::SceneState read(Check& check, const wire::WorldState& in) {
  scene::SceneState state;
  state.time = check.time<PhysicsClock>(in.time_ns(), "time_ns");
  state.tick = in.tick();
  check.count(in.bodies_size(), scene::SceneState::kBodies, "bodies");
  check.count(in.counters_size(), scene::SceneState::kCounters, "counters");
  if (!check.good()) return state;
  state.body_count = in.bodies_size();
  for (int i = 0; i < in.bodies_size(); ++i) {
    state.bodies[static_cast<std::size_t>(i)] = read(check, in.bodies(i));
  }
  for (int i = 0; i < in.counters_size(); ++i) state.counters[static_cast<std::size_t>(i)] = in.counters(i);
  state.impact.force = check.numbers<3>(in.impact_force_n(), "impact_force_n");
  state.impact.share = check.fraction(in.impact_share(), "impact_share");
  state.impact.point = check.numbers<3>(in.impact_point_m(), "impact_point_m");
  state.continuous.force = check.numbers<3>(in.continuous_force_n(), "continuous_force_n");
  state.continuous.touching = in.touching() ? 1 : 0;
  state.continuous.point = check.numbers<3>(in.touching_point_m(), "touching_point_m");
  return state;
}

scene::SceneSurface read(Check& check, const wire::SceneSurface& in) {
  scene::SceneSurface surface;
  surface.name = check.text(in.name(), kMaxNameBytes, "surface name");
  const auto x = check.numbers<12>(in.corners_m(), "corners_m");
  for (std::size_t i = 0; i < 4; ++i) surface.corners[i] = {x[3 * i], x[3 * i + 1], x[3 * i + 2]};
  return surface;
}

scene::MeshAsset read(Check& check, const wire::MeshAsset& in) {
  return {.file = check.text(in.file(), scene::kMaxMeshPathBytes, "mesh file"),
          .hash = check.text(in.hash(), kMaxNameBytes, "mesh hash"),
          .metres_per_unit = check.positive(in.metres_per_unit(), "metres_per_unit")};
}

scene::Payload read(Check& check, const wire::Payload& in) {
  check.require(in.version() != 0, "settings version", "1 or more");
  return {.version = in.version(), .bytes = check.bytes(in.content(), scene::kMaxPayloadBytes, "settings")};
}

scene::SceneDescription read(Check& check, const wire::SceneDescription& in) {
  scene::SceneDescription scene;
  scene.application = check.text(in.application(), kMaxNameBytes, "application");
  check.count(in.surfaces_size(), kMaxSurfaces, "surfaces");
  if (!check.good()) return scene;
  for (const wire::SceneSurface& surface : in.surfaces()) scene.surfaces.push_back(read(check, surface));
  check.count(in.arm_tips_m_size(), 3 * scene::SceneDescription::kMostArmTips, "arm_tips_m");
  check.require(in.arm_tips_m_size() % 3 == 0, "arm_tips_m", "three numbers a place");
  if (!check.good()) return scene;
  for (int i = 0; i < in.arm_tips_m_size(); i += 3)
    scene.arm_tips.emplace_back(check.finite(in.arm_tips_m(i), "arm_tips_m"),
                                check.finite(in.arm_tips_m(i + 1), "arm_tips_m"),
                                check.finite(in.arm_tips_m(i + 2), "arm_tips_m"));
  scene.gravity = check.vector(in.gravity_m_per_s2(), "gravity_m_per_s2");
  scene.carried_offset = check.vector(in.carried_offset_m(), "carried_offset_m");
  check.count(in.bodies_size(), scene::SceneState::kBodies, "body descriptions");
  for (const wire::BodyDescription& body : in.bodies()) {
    if (!check.good()) return scene;
    scene.bodies.push_back({check.text(body.name(), scene::kLongestBodyName, "body name"),
                            check.not_negative(body.mass_kg(), "mass_kg")});
  }
  check.require(in.shape_vertices() <= scene::Shape::kMaxVertices, "shape_vertices", "at most 40000");
  scene.shape_vertices = in.shape_vertices();
  if (in.has_mesh()) scene.mesh = read(check, in.mesh());
  if (in.has_settings()) scene.settings = read(check, in.settings());
  return scene;
}

Role read_role(Check& check, int role) {
  check.require(role >= wire::ROLE_OBSERVER && role <= wire::ROLE_OPERATOR, "role", "a known role");
  return check.good() ? static_cast<Role>(role - 1) : Role::observer;
}

constexpr double kMaxForceN = 1e4;
constexpr double kMaxTimeS = 1e-9 * static_cast<double>(kMaxTimeNs);

ClientCondition read(Check& check, const wire::DeviceCondition& in) {
  const auto code = from_wire(kWireHealthCodes, in.code());
  check.require(code.has_value(), "condition", "of a known code");
  return {.code = code.value_or(HealthCode::camera_silent),
          .age_s = check.within(in.age_s(), 0.0, kMaxTimeS, "age_s"),
          .words = check.text(in.words(), kMaxConditionBytes, "condition")};
}

ClientFigures read(Check& check, const wire::ClientFigures& in) {
  constexpr double kDayUs = 86400e6;
  check.count(in.conditions_size(), kMaxConditions, "conditions");
  std::vector<ClientCondition> conditions;
  for (const auto& condition : in.conditions())
    if (check.good()) conditions.push_back(read(check, condition));
  return {
      .frames = in.frames(),
      .late = in.late(),
      .lost = in.lost(),
      .rate_hz = check.within(in.rate_hz(), 0.0, 1e5, "rate_hz"),
      .round_trip_median_us = check.within(in.round_trip_median_us(), 0.0, kDayUs, "round_trip_median_us"),
      .round_trip_p99_us = check.within(in.round_trip_p99_us(), 0.0, kDayUs, "round_trip_p99_us"),
      .clock_offset_s = check.within(in.clock_offset_s(), -kMaxTimeS, kMaxTimeS, "clock_offset_s"),
      .clock_uncertainty_us =
          check.within(in.clock_uncertainty_us(), 0.0, 1e6 * kMaxTimeS, "clock_uncertainty_us"),
      .conditions = std::move(conditions)};
}

std::optional<device::ForceCondition> read_forces(Check& check, const wire::LoopStatus& in) {
  if (in.force_state() == wire::FORCE_STATE_NONE) return std::nullopt;
  const auto state = from_wire(kWireForceStates, in.force_state());
  const auto fault = from_wire(kWireForceFaults, in.force_fault());
  check.require(state && fault, "force condition", "a known state and fault");
  return check.good() ? std::optional(device::ForceCondition{*state, *fault}) : std::nullopt;
}

LoopStatus read(Check& check, const wire::LoopStatus& in) {
  check.count(in.late_octaves_size(), kMaxOctaves, "late_octaves");
  LoopStatus loop{.name = check.text(in.name(), kMaxNameBytes, "loop name"),
                  .rate_hz = check.finite(in.rate_hz(), "rate_hz"),
                  .ticks = in.ticks(),
                  .overruns = in.overruns(),
                  .missed = in.missed(),
                  .late_p50_us = check.finite(in.late_p50_us(), "late_p50_us"),
                  .late_p99_us = check.finite(in.late_p99_us(), "late_p99_us"),
                  .late_max_us = check.finite(in.late_max_us(), "late_max_us"),
                  .busy_p99_us = check.finite(in.busy_p99_us(), "busy_p99_us"),
                  .late_octaves = {},
                  .forces = read_forces(check, in),
                  .culprit = check.text(in.culprit(), kMaxNameBytes, "culprit"),
                  .peak_n = check.within(in.peak_n(), 0.0, kMaxForceN, "peak_n"),
                  .continuous_n = check.within(in.continuous_n(), 0.0, kMaxForceN, "continuous_n"),
                  .trips = in.trips()};
  if (check.good()) loop.late_octaves.assign(in.late_octaves().begin(), in.late_octaves().end());
  return loop;
}

StatusReply read(Check& check, const wire::StatusReply& in) {
  StatusReply reply;
  reply.number = check.number(in.number(), "number");
  ServerStatus& status = reply.status;
  status.uptime_s = check.finite(in.uptime_s(), "uptime_s");
  status.application = check.text(in.application(), kMaxNameBytes, "application");
  status.failure = check.text(in.failure(), kMaxReasonBytes, "failure");
  check.count(in.loops_size(), kMaxLoops, "loops");
  check.count(in.clients_size(), kMaxClientsTold, "clients");
  if (!check.good()) return reply;
  for (const auto& loop : in.loops()) status.loops.push_back(read(check, loop));
  for (const auto& client : in.clients())
    status.clients.push_back({check.text(client.name(), kMaxNameBytes, "client name"),
                              read_role(check, client.role()), read(check, client.figures())});
  status.requests = in.requests();
  status.syncs = in.syncs();
  status.controls = in.controls();
  status.rejected = in.rejected();
  status.rejected_connections = in.turned_away();
  status.unsent = in.unsent();
  status.published = in.published();
  if (in.has_recording())
    status.recording =
        RecordingStatus{check.within(in.recording().seconds(), 0.0, kMaxTimeS, "recording seconds"),
                        in.recording().dropped(), in.recording().ended()};
  return reply;
}

ClientMessage read(Check& check, const wire::ToPhysics& in) {
  switch (in.body_case()) {
    case wire::ToPhysics::kHello: {
      Hello hello{check.number(in.hello().client(), "client"), in.hello().known_session(),
                  check.text(in.hello().name(), kMaxNameBytes, "name"), std::nullopt};
      if (in.hello().has_figures()) hello.figures = read(check, in.hello().figures());
      return hello;
    }
    case wire::ToPhysics::kStatusRequest:
      return StatusRequest{check.number(in.status_request().number(), "number")};
    case wire::ToPhysics::kStateRequest:
      return StateRequest{check.number(in.state_request().number(), "number"),
                          check.time<PhysicsClock>(in.state_request().time_ns(), "time_ns"),
                          in.state_request().shape()};
    case wire::ToPhysics::kSyncRequest:
      return SyncRequest{check.number(in.sync_request().number(), "number")};
    case wire::ToPhysics::kControlCall: {
      const auto& call = in.control_call();
      check.require(call.control() >= wire::CONTROL_NONE && call.control() <= wire::CONTROL_RESUME, "control",
                    "a known control");
      return ControlCall{check.number(call.client(), "client"), check.number(call.number(), "number"),
                         check.good() ? static_cast<scene::Control>(call.control()) : scene::Control::none};
    }
    case wire::ToPhysics::kSubscribe: {
      const std::uint32_t rate_hz = in.subscribe().rate_hz();
      if (rate_hz < 1 || rate_hz > kMaxSubscriptionRate_hz)
        check.fail(fmt::format("rate_hz must be 1 to {}, not {}", kMaxSubscriptionRate_hz, rate_hz));
      return Subscribe{check.good() ? static_cast<int>(rate_hz) : 0};
    }
    case wire::ToPhysics::BODY_NOT_SET:
      break;
  }
  check.fail("the message is of no known kind; use the same release of palpate on both");
  return Hello{};
}

// Zero times a number is zero, unless it is infinite or none; in lanes, so that the compiler takes many at
// once.
bool all_finite(const std::vector<float>& values) {
  std::array<float, 8> sums{};
  std::size_t i = 0;
  for (; i + 8 <= values.size(); i += 8)
    for (std::size_t lane = 0; lane < 8; ++lane) sums[lane] += 0.0F * values[i + lane];
  for (; i < values.size(); ++i) sums[0] += 0.0F * values[i];
  return std::all_of(sums.begin(), sums.end(), [](float sum) { return sum == 0.0F; });
}

std::shared_ptr<const scene::Shape> read(Check& check, const wire::ShapeNote& note,
                                         std::span<const std::string_view> pieces) {
  std::size_t bytes = 0;
  for (const std::string_view piece : pieces) bytes += piece.size();
  auto shape = std::make_shared<scene::Shape>();
  shape->time = check.time<PhysicsClock>(note.time_ns(), "shape time_ns");
  check.require(note.vertices() >= 1 && note.vertices() <= scene::Shape::kMaxVertices, "vertices",
                "1 to 40000");
  check.require(bytes == std::size_t{note.vertices()} * scene::Shape::kFloatsPerVertex * sizeof(float),
                "the frames of a shape", "24 bytes for each vertex");
  if (!check.good()) return nullptr;
  shape->values.resize(bytes / sizeof(float));
  char* to = reinterpret_cast<char*>(shape->values.data());
  for (const std::string_view piece : pieces) to = std::copy(piece.begin(), piece.end(), to);
  check.require(all_finite(shape->values), "each number of a shape", "finite");
  return shape;
}

StateReply read(Check& check, const wire::StateReply& in) {
  StateReply reply;
  reply.number = check.number(in.number(), "number");
  reply.asked = check.time<PhysicsClock>(in.asked_time_ns(), "asked_time_ns");
  check.require(in.kind() >= wire::ANSWER_EXACT && in.kind() <= wire::ANSWER_TOO_NEW, "kind",
                "a known answer kind");
  reply.answer.extrapolated_by =
      check.time<PhysicsClock>(in.extrapolated_ns(), "extrapolated_ns").since_epoch;
  if (check.good()) reply.answer.kind = static_cast<AnswerKind>(in.kind());
  reply.answer.state = read(check, in.state());
  return reply;
}

ServerMessage read(Check& check, const wire::ToGraphics& in) {
  switch (in.body_case()) {
    case wire::ToGraphics::kWelcome: {
      Welcome welcome{check.number(in.welcome().session(), "session"), std::nullopt,
                      read_role(check, in.welcome().role()),
                      check.text(in.welcome().states(), kMaxReasonBytes, "states")};
      if (in.welcome().has_scene()) welcome.scene = read(check, in.welcome().scene());
      return welcome;
    }
    case wire::ToGraphics::kStateReply:
      return read(check, in.state_reply());
    case wire::ToGraphics::kSyncReply: {
      const auto& sync = in.sync_reply();
      check.require(sync.sent_ns() >= sync.received_ns(), "sent_ns", "not before received_ns");
      return SyncReply{check.number(sync.number(), "number"),
                       check.time<PhysicsClock>(sync.received_ns(), "received_ns"),
                       check.time<PhysicsClock>(sync.sent_ns(), "sent_ns")};
    }
    case wire::ToGraphics::kControlReply:
      return ControlReply{check.number(in.control_reply().number(), "number"),
                          check.text(in.control_reply().refusal(), kMaxReasonBytes, "refusal")};
    case wire::ToGraphics::kStatusReply:
      return read(check, in.status_reply());
    case wire::ToGraphics::kRefusal:
      return Refusal{check.text(in.refusal().reason(), kMaxReasonBytes, "reason")};
    case wire::ToGraphics::BODY_NOT_SET:
      break;
  }
  check.fail("the message is of no known kind");
  return ControlReply{};
}

// `more` reads what does not stand in the message itself.
template <typename Wire>
Expected<void> parse(Wire& in, std::string_view bytes) {
  if (bytes.size() > kMaxMessageBytes)
    return refused("message refused: {} bytes, at most {} are allowed", bytes.size(), kMaxMessageBytes);
  // protobuf writes about bad text on standard error: no peer is to fill that.
  static const bool silent = (google::protobuf::SetLogHandler(nullptr), true);
  static_cast<void>(silent);
  if (!in.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    return refused("message refused: {} bytes that are no message of palpate.proto, which is expected",
                   bytes.size());
  return {};
}

template <typename Wire>
auto decode_part(std::string_view bytes)
    -> Expected<decltype(read(std::declval<Check&>(), std::declval<const Wire&>()))> {
  MessageArena arena;
  Wire& in = arena.make<Wire>();
  if (auto parsed = parse(in, bytes); !parsed) return tl::unexpected(parsed.error());
  Check check;
  auto part = read(check, in);
  if (!check.good()) return refused("message refused: {}", check.reason());
  return part;
}

template <typename Wire, typename Message, typename More>
Expected<Message> decode_as(std::string_view bytes, More&& more) {
  MessageArena arena;
  Wire& in = arena.make<Wire>();
  if (auto parsed = parse(in, bytes); !parsed) return tl::unexpected(parsed.error());
  if (in.protocol() != kProtocol) {
    return refused(
        "message refused: protocol {}, this side speaks {}; use the same release of palpate on both",
        in.protocol(), kProtocol);
  }
  Check check;
  Message message = read(check, in);
  if (check.good()) more(check, in, message);
  if (!check.good()) return refused("message refused: {}", check.reason());
  return message;
}

}  // namespace

Expected<scene::SceneState> decode_state(std::string_view bytes) {
  return decode_part<wire::WorldState>(bytes);
}

Expected<scene::SceneDescription> decode_scene(std::string_view bytes) {
  return decode_part<wire::SceneDescription>(bytes);
}

Expected<ClientMessage> decode_client_message(std::string_view bytes) {
  return decode_as<wire::ToPhysics, ClientMessage>(bytes, [](auto&...) {});
}

Expected<ServerMessage> decode_server_message(std::string_view bytes,
                                              std::span<const std::string_view> shape) {
  return decode_as<wire::ToGraphics, ServerMessage>(
      bytes, [&](Check& check, const wire::ToGraphics& in, ServerMessage& message) {
        const bool announced = in.has_state_reply() && in.state_reply().has_shape();
        check.require(announced == !shape.empty(), "further frames", "there just where a shape is announced");
        if (announced && check.good())
          std::get<StateReply>(message).shape = read(check, in.state_reply().shape(), shape);
      });
}

}  // namespace palpate::transport
