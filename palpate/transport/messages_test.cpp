// The wire format: what goes in comes out to the bit, and nothing that is wrong gets through.
#include "palpate/transport/messages.h"

#include <gtest/gtest.h>
#include <palpate.pb.h>

#include <cmath>
#include <functional>
#include <limits>

#include "palpate/core/random.h"
#include "palpate/core/text.h"
#include "palpate/scene/mesh_asset.h"
#include "palpate/transport/exchange_rig_test.h"

namespace palpate::transport {
namespace {

// A state whose every number is drawn; counts too.
scene::SceneState random_state(Random& random) {
  scene::SceneState state;
  state.time = {Duration(static_cast<std::int64_t>(random.bits() >> 4))};
  state.tick = random.bits();
  state.body_count = static_cast<int>(random.below(scene::SceneState::kBodies + 1));
  for (int i = 0; i < state.body_count; ++i) {
    scene::BodyState& body = state.bodies[static_cast<std::size_t>(i)];
    for (double& x : body.position) x = random.normal(10.0);
    body.set_q(Quaternion(random.normal(), random.normal(), random.normal(), random.normal()).normalized());
    for (double& x : body.velocity) x = random.normal(1e-300);
    for (double& x : body.angular_velocity) x = random.normal(1e300);
    body.jumps = static_cast<std::uint32_t>(random.bits());
    body.visible = random.chance(0.5) ? 1 : 0;
  }
  for (std::int32_t& counter : state.counters) counter = static_cast<std::int32_t>(random.bits());
  for (double& x : state.impact.force) x = random.normal();
  state.impact.share = random.uniform();
  for (double& x : state.impact.point) x = random.normal();
  for (double& x : state.continuous.force) x = random.normal();
  state.continuous.touching = random.chance(0.5) ? 1 : 0;
  for (double& x : state.continuous.point) x = random.normal();
  return state;
}

void expect_same(const scene::SceneState& a, const scene::SceneState& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.tick, b.tick);
  ASSERT_EQ(a.body_count, b.body_count);
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    EXPECT_EQ(a.bodies[i].position, b.bodies[i].position);
    EXPECT_EQ(a.bodies[i].orientation, b.bodies[i].orientation);
    EXPECT_EQ(a.bodies[i].velocity, b.bodies[i].velocity);
    EXPECT_EQ(a.bodies[i].angular_velocity, b.bodies[i].angular_velocity);
    EXPECT_EQ(a.bodies[i].jumps, b.bodies[i].jumps);
    EXPECT_EQ(a.bodies[i].visible, b.bodies[i].visible);
  }
  EXPECT_EQ(a.counters, b.counters);
  EXPECT_EQ(a.impact.force, b.impact.force);
  EXPECT_EQ(a.impact.share, b.impact.share);
  EXPECT_EQ(a.impact.point, b.impact.point);
  EXPECT_EQ(a.continuous.force, b.continuous.force);
  EXPECT_EQ(a.continuous.touching, b.continuous.touching);
  EXPECT_EQ(a.continuous.point, b.continuous.point);
}

TEST(Messages, EveryStateComesBackToTheBit) {
  Random random(1, "test/messages");
  for (int i = 0; i < 500; ++i) {
    StateReply reply{1 + random.below(1000), {Duration(static_cast<std::int64_t>(random.bits() >> 4))}, {}};
    reply.answer = {static_cast<AnswerKind>(random.below(5)),
                    Duration(static_cast<int>(random.below(1000000))), random_state(random)};
    const auto back = decode_server_message(encode(ServerMessage(reply)));
    ASSERT_TRUE(back) << back.error().message;
    const auto& got = std::get<StateReply>(*back);
    EXPECT_EQ(got.number, reply.number);
    EXPECT_EQ(got.asked, reply.asked);
    EXPECT_EQ(got.answer.kind, reply.answer.kind);
    EXPECT_EQ(got.answer.extrapolated_by, reply.answer.extrapolated_by);
    expect_same(got.answer.state, reply.answer.state);
  }
}

TEST(Messages, AStatusComesBackWholeAndIsBounded) {
  StatusReply reply{7, {}};
  reply.status.uptime_s = 12.5;
  reply.status.application = "marbles";
  reply.status.failure = "the application 'marbles' threw: lost them";
  reply.status.loops.push_back(
      {"haptic", 999.5, 1000, 3, 4, 1.5, 2.5, 3.5, 4.5, std::vector<std::uint64_t>{0, 5, 7}});
  reply.status.loops[0].forces =
      device::ForceCondition{device::ForceState::safe, device::ForceFault::overspeed};
  reply.status.loops[0].culprit = "marbles";
  reply.status.loops[0].peak_n = 8.5, reply.status.loops[0].continuous_n = 1.4,
  reply.status.loops[0].trips = 9;
  reply.status.recording = RecordingStatus{12.0, 8, true};
  reply.status.clients.push_back({"screen",
                                  Role::graphics,
                                  {100,
                                   2,
                                   1,
                                   29.9,
                                   150.0,
                                   300.0,
                                   1234.5,
                                   20.0,
                                   {{device::HealthCode::board_lost, 2.5, "camera: no image"}}}});
  reply.status.requests = 1, reply.status.syncs = 2, reply.status.controls = 3, reply.status.rejected = 4;
  reply.status.rejected_connections = 5, reply.status.unsent = 6, reply.status.published = 7;
  const auto back = decode_server_message(encode(ServerMessage(reply)));
  ASSERT_TRUE(back) << back.error().message;
  const auto& got = std::get<StatusReply>(*back).status;
  EXPECT_EQ(encode(ServerMessage(StatusReply{7, got})), encode(ServerMessage(reply)));
  ASSERT_EQ(got.loops.size(), 1u);
  EXPECT_EQ(got.loops[0].late_octaves, reply.status.loops[0].late_octaves);
  EXPECT_EQ(got.loops[0].late_max_us, 3.5);
  EXPECT_EQ(got.loops[0].peak_n, 8.5);
  EXPECT_EQ(got.loops[0].continuous_n, 1.4);
  EXPECT_EQ(got.loops[0].trips, 9u);
  EXPECT_EQ(got.failure, reply.status.failure);
  ASSERT_TRUE(got.recording);
  EXPECT_EQ(got.recording->seconds, 12.0);
  EXPECT_EQ(got.recording->dropped, 8u);
  EXPECT_TRUE(got.recording->ended);
  EXPECT_EQ(got.loops[0].forces, reply.status.loops[0].forces);
  EXPECT_EQ(got.loops[0].forces_text(), "safe: overspeed (marbles)");
  ASSERT_EQ(got.clients.size(), 1u);
  EXPECT_EQ(got.clients[0].role, Role::graphics);
  const ClientFigures& figures = got.clients[0].figures;
  EXPECT_EQ(figures.frames, 100u);
  EXPECT_EQ(figures.late, 2u);
  EXPECT_EQ(figures.lost, 1u);
  EXPECT_EQ(figures.rate_hz, 29.9);
  EXPECT_EQ(figures.round_trip_median_us, 150.0);
  EXPECT_EQ(figures.round_trip_p99_us, 300.0);
  EXPECT_EQ(figures.clock_offset_s, 1234.5);
  EXPECT_EQ(figures.clock_uncertainty_us, 20.0);
  ASSERT_EQ(figures.conditions.size(), 1u);
  EXPECT_EQ(figures.conditions[0].code, device::HealthCode::board_lost);
  EXPECT_EQ(figures.conditions[0].age_s, 2.5);
  EXPECT_EQ(figures.conditions[0].words, "camera: no image");
  EXPECT_EQ(got.published, 7u);

  auto many = reply;
  many.status.clients.resize(65, reply.status.clients[0]);
  EXPECT_FALSE(decode_server_message(encode(ServerMessage(many))));
  auto wide = reply;
  wide.status.loops[0].late_octaves.resize(41);
  EXPECT_FALSE(decode_server_message(encode(ServerMessage(wide))));
  auto odd = reply;
  odd.status.clients[0].figures.rate_hz = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(decode_server_message(encode(ServerMessage(odd))));
}

TEST(Messages, EveryConditionOfTheForcesTravelsByItsNumber) {
  using device::ForceFault;
  using device::ForceState;
  for (int state = 0; state <= static_cast<int>(ForceState::safe); ++state) {
    for (int fault = 0; fault <= static_cast<int>(ForceFault::not_armed); ++fault) {
      const device::ForceCondition sent{static_cast<ForceState>(state), static_cast<ForceFault>(fault)};
      StatusReply reply{1, {}};
      reply.status.loops.emplace_back().forces = sent;
      const auto back = decode_server_message(encode(ServerMessage(reply)));
      ASSERT_TRUE(back) << back.error().message;
      EXPECT_EQ(std::get<StatusReply>(*back).status.loops[0].forces, sent);
    }
  }
  // Of a later version, or made up.
  wire::ToGraphics made;
  ASSERT_TRUE(made.ParseFromString(encode(ServerMessage(StatusReply{1, {}}))));
  auto* loop = made.mutable_status_reply()->add_loops();
  loop->set_force_state(wire::FORCE_STATE_SAFE);
  EXPECT_TRUE(decode_server_message(made.SerializeAsString()));
  for (const int odd : {-1, 15, 1 << 30}) {
    loop->set_force_fault(static_cast<wire::ForceFault>(odd));
    EXPECT_FALSE(decode_server_message(made.SerializeAsString())) << odd;
  }
}

TEST(Messages, ASceneComesBackWhole) {
  scene::SceneDescription scene = testing::table_scene("touch");
  scene.gravity = {0.1, 0.2, -9.7};
  scene.arm_tips = {{0.1, 0.2, 0.3}, {-0.4, 0.5, 0.6}};
  scene.carried_offset = {1, 2, 3};
  scene.bodies = {{"Liver", 0.0}, {"Needle", 0.031}};
  scene.mesh = scene::MeshAsset{"/meshes/liver.stl", "fnv1a64:0123456789abcdef", 0.01, nullptr};
  scene.settings = {3, std::string("bytes of any kind\0\xff", 20)};
  const auto back = decode_server_message(encode(ServerMessage(Welcome{77, scene})));
  ASSERT_TRUE(back) << back.error().message;
  const auto& welcome = std::get<Welcome>(*back);
  EXPECT_EQ(welcome.session, 77u);
  ASSERT_TRUE(welcome.scene.has_value());
  EXPECT_EQ(welcome.scene->application, "touch");
  EXPECT_EQ(welcome.scene->surfaces[0].name, "table");
  EXPECT_EQ(welcome.scene->surfaces[0].corners, scene.surfaces[0].corners);
  EXPECT_EQ(welcome.scene->gravity, scene.gravity);
  EXPECT_EQ(welcome.scene->arm_tips, scene.arm_tips);
  EXPECT_EQ(welcome.scene->carried_offset, scene.carried_offset);
  ASSERT_EQ(welcome.scene->bodies.size(), 2u);
  EXPECT_EQ(welcome.scene->bodies[1].name, "Needle");
  EXPECT_EQ(welcome.scene->bodies[1].mass, 0.031);
  ASSERT_TRUE(welcome.scene->mesh);
  EXPECT_EQ(welcome.scene->mesh->file, scene.mesh->file);
  EXPECT_EQ(welcome.scene->mesh->hash, scene.mesh->hash);
  EXPECT_EQ(welcome.scene->mesh->metres_per_unit, 0.01);
  EXPECT_EQ(welcome.scene->settings, scene.settings);
}

TEST(Messages, SmallMessagesComeBack) {
  const auto hello = decode_client_message(encode(ClientMessage(Hello{11, 12, "me"})));
  ASSERT_TRUE(hello);
  EXPECT_EQ(std::get<Hello>(*hello).client, 11u);
  EXPECT_EQ(std::get<Hello>(*hello).known_session, 12u);
  EXPECT_EQ(std::get<Hello>(*hello).name, "me");
  const auto ask = decode_client_message(encode(ClientMessage(StateRequest{3, {Duration(-5)}})));
  ASSERT_TRUE(ask);
  EXPECT_EQ(std::get<StateRequest>(*ask).time.ns(), -5);
  const auto call = decode_client_message(encode(ClientMessage(ControlCall{1, 2, scene::Control::resume})));
  ASSERT_TRUE(call);
  EXPECT_EQ(std::get<ControlCall>(*call).control, scene::Control::resume);
  for (const int rate_hz : {1, 1000}) {
    const auto subscribe = decode_client_message(encode(ClientMessage(Subscribe{rate_hz})));
    ASSERT_TRUE(subscribe);
    EXPECT_EQ(std::get<Subscribe>(*subscribe).rate_hz, rate_hz);
  }
  for (const int rate_hz : {0, 1001, -1})
    EXPECT_FALSE(decode_client_message(encode(ClientMessage(Subscribe{rate_hz})))) << rate_hz;
  const auto sync = decode_server_message(encode(ServerMessage(SyncReply{4, {Duration(8)}, {Duration(9)}})));
  ASSERT_TRUE(sync);
  EXPECT_EQ(std::get<SyncReply>(*sync).t3.ns(), 9);
  const auto refusal = decode_server_message(encode(ServerMessage(Refusal{std::string(5000, 'x')})));
  ASSERT_TRUE(refusal);
  EXPECT_EQ(std::get<Refusal>(*refusal).reason.size(), kMaxReasonBytes);
}

// One good reply, spoiled by `spoil` on the wire.
std::string refusal_of(const std::function<void(wire::ToGraphics&)>& spoil) {
  StateReply reply{1, {Duration(1)}, testing::state_at({seconds(1)})};
  wire::ToGraphics message;
  EXPECT_TRUE(message.ParseFromString(encode(ServerMessage(reply))));
  spoil(message);
  const auto decoded = decode_server_message(message.SerializeAsString());
  return decoded ? "accepted" : decoded.error().message;
}

TEST(Messages, EachWrongValueIsRefusedByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto state = [](wire::ToGraphics& m) { return m.mutable_state_reply()->mutable_state(); };
  EXPECT_EQ(refusal_of([](wire::ToGraphics&) {}), "accepted");
  EXPECT_NE(
      refusal_of([&](auto& m) { state(m)->mutable_bodies(0)->set_position_m(1, nan); }).find("position_m"),
      std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) {
              state(m)->mutable_bodies(0)->add_position_m(1);
            }).find("position_m must be 3 numbers, not 4"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) {
              state(m)->mutable_bodies(0)->set_orientation_wxyz(0, 1.1);
            }).find("unit quaternion"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) {
              state(m)->mutable_bodies(1)->set_velocity_m_per_s(0, HUGE_VAL);
            }).find("velocity_m_per_s"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) {
              for (int i = 0; i < 7; ++i) *state(m)->add_bodies() = state(m)->bodies(0);
            }).find("bodies must be at most 8, not 9"),
            std::string::npos);
  EXPECT_NE(
      refusal_of([&](auto& m) { state(m)->add_counters(1); }).find("counters must be at most 16, not 17"),
      std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) { state(m)->clear_impact_force_n(); }).find("impact_force_n"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) { state(m)->add_continuous_force_n(1.0); }).find("continuous_force_n"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) { state(m)->clear_touching_point_m(); }).find("touching_point_m"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) { state(m)->set_impact_share(nan); }).find("impact_share"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) { state(m)->set_impact_share(1.5); }).find("impact_share"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) {
              state(m)->set_time_ns(std::numeric_limits<std::int64_t>::min());
            }).find("time_ns"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) {
              m.mutable_state_reply()->set_kind(static_cast<wire::AnswerKind>(5));
            }).find("kind"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) { m.mutable_state_reply()->set_number(0); }).find("number"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) { m.set_protocol(1); }).find("protocol 1, this side speaks 2"),
            std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) { m.clear_body(); }).find("no known kind"), std::string::npos);
  EXPECT_NE(refusal_of([&](auto& m) { m.mutable_sync_reply()->set_received_ns(5); }).find("sent_ns"),
            std::string::npos);
}

// They are shown on the terminal of whoever asks how the server is doing. U+009B begins a command to it,
// U+202E turns what follows around.
TEST(Messages, TextsThatSteerATerminalAreRefused) {
  for (const std::string odd : {"\x1B[31m", "a\nb", "a\u009B31m", "a\u202Eb", "\u2066", "\uFEFFa"}) {
    wire::ToPhysics hello;
    hello.set_protocol(kProtocol);
    hello.mutable_hello()->set_client(1);
    hello.mutable_hello()->set_name(odd);
    const auto named = decode_client_message(hello.SerializeAsString());
    ASSERT_FALSE(named) << odd;
    EXPECT_NE(named.error().message.find("name must be without control characters"), std::string::npos)
        << named.error().message;
    EXPECT_TRUE(is_plain(named.error().message)) << "and the refusal is fit to be shown";
    hello.mutable_hello()->set_name("graphics");
    ASSERT_TRUE(decode_client_message(hello.SerializeAsString()));
    hello.mutable_hello()->mutable_figures()->add_conditions()->set_words(odd);
    hello.mutable_hello()->mutable_figures()->mutable_conditions(0)->set_code(
        wire::HEALTH_CODE_CAMERA_SILENT);
    EXPECT_FALSE(decode_client_message(hello.SerializeAsString())) << odd;
    EXPECT_NE(refusal_of([&](auto& m) { m.mutable_refusal()->set_reason(odd); }), "accepted");
  }
}

TEST(Messages, ASceneBeyondTheBoundsIsRefused) {
  scene::SceneDescription scene = testing::table_scene();
  scene.surfaces.resize(65, scene.surfaces[0]);
  EXPECT_FALSE(decode_server_message(encode(ServerMessage(Welcome{1, scene}))));
  scene = testing::table_scene();
  scene.carried_offset.x() = std::nan("");
  EXPECT_FALSE(decode_server_message(encode(ServerMessage(Welcome{1, scene}))));
  scene = testing::table_scene(std::string(65, 'a'));
  EXPECT_FALSE(decode_server_message(encode(ServerMessage(Welcome{1, scene}))));
  scene = testing::table_scene();
  scene.bodies.resize(9);
  EXPECT_FALSE(decode_server_message(encode(ServerMessage(Welcome{1, scene}))));
}

std::string refusal_of_scene(const std::function<void(scene::SceneDescription&)>& spoil) {
  scene::SceneDescription scene = testing::table_scene();
  spoil(scene);
  const auto read = decode_server_message(encode(ServerMessage(Welcome{1, scene})));
  return read ? std::string() : read.error().message;
}

TEST(Messages, WhatAnApplicationSaysOfASceneIsBounded) {
  using Scene = scene::SceneDescription;
  const auto expect = [](const std::string& words, const std::function<void(Scene&)>& spoil) {
    EXPECT_NE(refusal_of_scene(spoil).find(words), std::string::npos) << refusal_of_scene(spoil);
  };
  EXPECT_EQ(refusal_of_scene([](Scene&) {}), "");
  expect("body name must be at most 64", [](Scene& s) { s.bodies = {{std::string(65, 'b'), 0.0}}; });
  expect("mass_kg must be finite and 0", [](Scene& s) { s.bodies = {{"Ball", -1.0}}; });
  expect("mass_kg", [](Scene& s) { s.bodies = {{"Ball", std::numeric_limits<double>::infinity()}}; });
  expect("mesh file must be at most 512", [](Scene& s) { s.mesh = scene::MeshAsset{std::string(513, 'f')}; });
  expect("metres_per_unit", [](Scene& s) { s.mesh = scene::MeshAsset{"a.stl", "", 0.0, nullptr}; });
  expect("settings must be at most 32768", [](Scene& s) {
    s.settings = {1, std::string(scene::kMaxPayloadBytes + 1, 'x')};
  });
  EXPECT_EQ(refusal_of_scene([](Scene& s) {
              s.settings = {1, std::string(scene::kMaxPayloadBytes, 'x')};
            }),
            "");
}

TEST(Messages, TheLargestSceneFitsAMessage) {
  scene::SceneDescription scene = testing::table_scene(std::string(kMaxNameBytes, 'a'));
  scene.surfaces[0].name = std::string(kMaxNameBytes, 's');
  scene.surfaces.resize(kMaxSurfaces, scene.surfaces[0]);
  scene.bodies.assign(scene::SceneState::kBodies, {std::string(scene::kLongestBodyName, 'b'), 1.0});
  scene.mesh = scene::MeshAsset{std::string(scene::kMaxMeshPathBytes, 'm'), std::string(kMaxNameBytes, 'h')};
  scene.settings = {~std::uint32_t{0}, std::string(scene::kMaxPayloadBytes, 's')};
  EXPECT_TRUE(decode_server_message(encode(ServerMessage(Welcome{1, scene}))));
}

TEST(Messages, AShapeTravelsInPiecesAndIsCheckedWhole) {
  auto shape = std::make_shared<scene::Shape>();
  shape->time = {Duration(5)};
  shape->values.assign(60000, 0.25F);
  shape->values[59999] = -1e30F;
  StateReply reply{1, {Duration(1)}, testing::state_at({seconds(1)}), shape};
  const std::string bytes = encode(ServerMessage(reply));
  const auto pieces = shape_pieces(*shape, kShapePieceBytes);
  EXPECT_EQ(pieces.size(), 8u);
  const auto back = decode_server_message(bytes, pieces);
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_TRUE(shape_of(*back));
  EXPECT_EQ(shape_of(*back)->values, shape->values);
  EXPECT_EQ(shape_of(*back)->time, shape->time);

  EXPECT_FALSE(decode_server_message(bytes));  // announced, and not there
  for (const std::size_t cut : {std::size_t{1}, std::size_t{24}, pieces[3].size()}) {
    auto shorter = pieces;
    shorter[3].remove_prefix(cut);
    EXPECT_FALSE(decode_server_message(bytes, shorter)) << cut;
  }
  EXPECT_FALSE(decode_server_message(bytes, std::array{std::string_view()}));
  // Any pieces will do that are the numbers together.
  const std::string_view numbers(pieces[0].data(), shape->values.size() * sizeof(float));
  EXPECT_TRUE(decode_server_message(bytes, std::array{numbers}));
  EXPECT_TRUE(decode_server_message(bytes, std::array{numbers.substr(0, 7), numbers.substr(7)}));
  reply.shape = nullptr;
  EXPECT_FALSE(decode_server_message(encode(ServerMessage(reply)), pieces));  // there, and not announced
  EXPECT_FALSE(decode_server_message(encode(ServerMessage(Refusal{"no"})), pieces));
  for (const float odd : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    for (const std::size_t where : {std::size_t{0}, std::size_t{33333}, std::size_t{59999}}) {
      auto spoiled = std::make_shared<scene::Shape>(*shape);
      spoiled->values[where] = odd;
      EXPECT_FALSE(decode_server_message(bytes, shape_pieces(*spoiled))) << odd << " at " << where;
    }
  }
  shape->values.resize((scene::Shape::kMaxVertices + 1) * scene::Shape::kFloatsPerVertex, 0.0F);
  reply.shape = shape;
  EXPECT_FALSE(decode_server_message(encode(ServerMessage(reply)), shape_pieces(*shape)));
}

TEST(Messages, GarbageIsRefusedAndDoesNoHarm) {
  Random random(2, "test/garbage");
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string bytes(random.below(300), '\0');
    for (char& c : bytes) c = static_cast<char>(random.bits());
    accepted += decode_client_message(bytes).has_value() + decode_server_message(bytes).has_value();
  }
  EXPECT_EQ(accepted, 0);
  EXPECT_FALSE(decode_client_message(""));
  EXPECT_FALSE(decode_server_message(std::string(kMaxMessageBytes + 1, '\0')));
}

TEST(Messages, AGoodMessageWithAnySpoiledByteIsRefusedOrStillWithinTheBounds) {
  Random random(3, "test/spoiled");
  const std::string good =
      encode(ServerMessage(StateReply{1, {Duration(1)}, testing::state_at({seconds(1)})}));
  int refused_count = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = good;
    bytes[random.below(bytes.size())] = static_cast<char>(random.bits());
    if (random.chance(0.2)) bytes.resize(random.below(bytes.size()));
    const auto decoded = decode_server_message(bytes);
    if (!decoded) {
      ++refused_count;
      continue;
    }
    const auto* reply = std::get_if<StateReply>(&*decoded);
    if (reply == nullptr) continue;
    const scene::SceneState& state = reply->answer.state;
    ASSERT_LE(state.body_count, scene::SceneState::kBodies);
    ASSERT_LE(static_cast<int>(reply->answer.kind), 4);
    for (const scene::BodyState& body : state.bodies) {
      for (double x : body.position) ASSERT_TRUE(std::isfinite(x));
      ASSERT_NEAR(body.q().norm(), 1.0, 2e-3);
    }
    ASSERT_TRUE(state.impact.share >= 0.0 && state.impact.share <= 1.0);
  }
  EXPECT_GT(refused_count, 1000);
}

}  // namespace
}  // namespace palpate::transport
