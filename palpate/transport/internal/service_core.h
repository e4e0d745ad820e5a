// What a physics server answers to each message, whatever engine carries it.
//
// answer() on one thread (the engine's); take_control() on one other (the physics loop); counters() anywhere.
#pragma once

#include <array>
#include <atomic>
#include <functional>

#include "palpate/transport/internal/handover_queue.h"
#include "palpate/transport/internal/shape_pool.h"
#include "palpate/transport/keys.h"
#include "palpate/transport/messages.h"
#include "palpate/transport/state_service.h"

namespace palpate::transport {

class ServiceCore {
 public:
  // Counted ten times a second, so that it shows within a second.
  static constexpr Duration kClientGoneAfter = std::chrono::milliseconds(800);
  static constexpr std::size_t kMaxClients = 64;
  static constexpr std::size_t kMaxClientsOfKey = 8;  // nobody can take all places
  static constexpr std::size_t kForOperators = 4;     // of all places, the last ones
  using Now = std::function<Instant<PhysicsClock>()>;

  // `session` is a random number for the server's life, not 0. `now` gives the time stamps.
  ServiceCore(StateSource source, scene::SceneDescription scene, std::uint64_t session, Now now);

  // The reply to the bytes of one message that came at `received` from a client of this role; none: it is not
  // admitted (any more). Bytes that fail the check, and what the role may not have, are refused in words.
  // `peer`: whose queue the answer goes to, a connection; one client at a time lives on it. `key`: of that
  // client, empty where the connection is not encrypted.
  ServerMessage answer(std::string_view bytes, Instant<PhysicsClock> received, std::optional<Role> role,
                       std::string_view peer = {}, std::string_view key = {});
  // Where shapes come from; before the first message.
  void set_shape_source(ShapeSource source);
  // Where the status comes from; before the first message.
  void set_status_source(StatusSource status) { status_ = std::move(status); }
  // Counts kept elsewhere in the engine, for the status.
  void set_counts(std::uint64_t rejected_connections, std::uint64_t published) {
    rejected_connections_ = rejected_connections, published_ = published;
  }
  // Where observers subscribe to states, told to every client; before the first message.
  void set_states_endpoint(std::string states_endpoint) { states_ = std::move(states_endpoint); }
  // Counts the clients anew; call a few times per second.
  void count_clients();
  void unsent(std::uint64_t count = 1) { unsent_.fetch_add(count, std::memory_order_relaxed); }
  void rejected(std::uint64_t count = 1) { rejected_.fetch_add(count, std::memory_order_relaxed); }

  std::optional<scene::Control> take_control();
  ServiceCounters counters() const;

 private:
  struct Client {
    std::uint64_t id = 0;
    std::uint64_t last_control = 0;
    Instant<PhysicsClock> heard;
    std::string peer, key;
    ClientStatus told;
  };

  ServerMessage answer(const Hello& message, Instant<PhysicsClock> received, Role role);
  ServerMessage answer(const StateRequest& message, Instant<PhysicsClock> received, Role role);
  ServerMessage answer(const SyncRequest& message, Instant<PhysicsClock> received, Role role);
  ServerMessage answer(const StatusRequest& message, Instant<PhysicsClock> received, Role role);
  ServerMessage answer(const ControlCall& message, Instant<PhysicsClock> received, Role role);
  ServerMessage answer(const Subscribe& message, Instant<PhysicsClock> received, Role role);
  Client* find(std::uint64_t id);
  Client* admit(std::uint64_t id, Instant<PhysicsClock> now, Role role);

  StateSource source_;
  ShapeSource shape_source_;
  ShapePool shapes_{0};
  std::string_view peer_, key_;  // of the message being answered
  scene::SceneDescription scene_;
  std::uint64_t session_;
  std::string states_;
  StatusSource status_;
  std::uint64_t rejected_connections_ = 0, published_ = 0;  // the engine's thread alone
  Now now_;
  std::array<Client, kMaxClients> clients_{};
  HandoverQueue<scene::Control, 32> controls_;
  std::atomic<int> client_count_{0};
  std::atomic<std::uint64_t> requests_{0}, syncs_{0}, control_count_{0}, rejected_{0}, unsent_{0};
};

}  // namespace palpate::transport
