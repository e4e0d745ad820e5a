// The messages between physics server and graphics servers as plain values, and their bytes
// (proto/palpate.proto).
//
// decode() checks everything before it returns: size, protocol, counts, finite numbers, ranges; what it
// returns can be used without a further look. It never throws and never crashes, whatever the bytes. Any
// thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/scene/application.h"
#include "palpate/scene/scene_state.h"
#include "palpate/scene/shape.h"
#include "palpate/time/instant.h"
#include "palpate/transport/keys.h"
#include "palpate/transport/status.h"

namespace palpate::transport {

inline constexpr std::uint32_t kProtocol = 2;
inline constexpr std::size_t kMaxMessageBytes = 64 * 1024;  // a description with 64 surfaces takes 12 KiB
inline constexpr std::size_t kMaxShapeBytes =
    scene::Shape::kMaxVertices * scene::Shape::kFloatsPerVertex * sizeof(float);
// Encrypted, a shape travels in pieces of this size: while one is on its way the next is encrypted on this
// side and the one before decrypted on the other. Else in one, for each piece costs wake-ups.
inline constexpr std::size_t kShapePieceBytes = 32 * 1024;
inline constexpr std::size_t kMaxShapePieces = (kMaxShapeBytes + kShapePieceBytes - 1) / kShapePieceBytes;
inline constexpr int kMaxSurfaces = 64;
inline constexpr std::size_t kMaxNameBytes = 64;
inline constexpr std::size_t kMaxReasonBytes = 512;
// Of one client: four can hold at the same time. 64 clients that have all of them fit into an answer.
inline constexpr int kMaxConditions = 4;
inline constexpr std::size_t kMaxConditionBytes = 180;
inline constexpr int kMaxSubscriptionRate_hz = 1000;

// Graphics server to physics server.
struct Hello {
  std::uint64_t client = 0;         // random, for life, not 0
  std::uint64_t known_session = 0;  // whose description the client has, 0 = none
  std::string name;
  std::optional<ClientFigures> figures;
};
struct StatusRequest {
  std::uint64_t number = 0;
};
struct StateRequest {
  std::uint64_t number = 0;
  Instant<PhysicsClock> time;
  bool shape = false;  // with the shape of the surface that deforms
};
struct SyncRequest {
  std::uint64_t number = 0;
};
struct ControlCall {
  std::uint64_t client = 0;
  std::uint64_t number = 0;
  scene::Control control = scene::Control::none;
};
// To the states' socket: states by themselves, so many a second. Again every second, as long as they are
// wanted.
struct Subscribe {
  int rate_hz = 0;
};
using ClientMessage = std::variant<Hello, StateRequest, SyncRequest, ControlCall, StatusRequest, Subscribe>;

// Physics server to graphics server.
struct Welcome {
  std::uint64_t session = 0;  // random, for the server's life, not 0
  std::optional<scene::SceneDescription> scene;
  Role role = Role::observer;  // of the client
  std::string states;          // where observers subscribe to states; empty = nowhere
};
struct StateReply {
  std::uint64_t number = 0;
  Instant<PhysicsClock> asked;
  scene::StateAnswer answer;
  // Where it was asked for and there is one. Its numbers travel in frames of their own, shape_pieces().
  std::shared_ptr<const scene::Shape> shape;
};
struct SyncReply {
  std::uint64_t number = 0;
  Instant<PhysicsClock> t2, t3;
};
struct ControlReply {
  std::uint64_t number = 0;
  std::string refusal;  // why it was not carried out; empty: it was
};
struct Refusal {
  std::string reason;
};
struct StatusReply {
  std::uint64_t number = 0;
  ServerStatus status;
};
using ServerMessage = std::variant<Welcome, StateReply, SyncReply, ControlReply, Refusal, StatusReply>;

std::string encode(const ClientMessage& message);
std::string encode(const ServerMessage& message);
Expected<ClientMessage> decode_client_message(std::string_view bytes);
// `shape`: the frames that came after the first, in their order.
Expected<ServerMessage> decode_server_message(std::string_view bytes,
                                              std::span<const std::string_view> shape = {});

// What stands in messages by itself, as recordings keep it and viewers get it: a WorldState, a SceneDescription, a
// StatusReply of palpate.proto.
std::string encode(const scene::SceneState& state);
std::string encode(const ServerStatus& status);
std::string encode(const scene::SceneDescription& scene);
Expected<scene::SceneState> decode_state(std::string_view bytes);
Expected<scene::SceneDescription> decode_scene(std::string_view bytes);

// The second frame of a message; nothing where it has none.
std::shared_ptr<const scene::Shape> shape_of(const ServerMessage& message);
// Its numbers, cut in pieces of so many bytes; they point into `shape`.
std::vector<std::string_view> shape_pieces(const scene::Shape& shape,
                                           std::size_t piece_bytes = kMaxShapeBytes);

}  // namespace palpate::transport
