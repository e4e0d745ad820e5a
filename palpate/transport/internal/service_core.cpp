#include "palpate/transport/internal/service_core.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace palpate::transport {

ServiceCore::ServiceCore(StateSource source, scene::SceneDescription scene, std::uint64_t session, Now now)
    : source_(std::move(source)), scene_(std::move(scene)), session_(session), now_(std::move(now)) {
  if (!source_ || !now_) throw std::invalid_argument("state service: no state source or no clock");
  // A description no client would accept is a mistake of this program, found here and not on the other side.
  const auto checked = decode_server_message(encode(Welcome{session_, scene_, Role::observer, {}}));
  if (!checked) throw std::invalid_argument("state service: " + checked.error().message);
}

ServerMessage ServiceCore::answer(std::string_view bytes, Instant<PhysicsClock> received,
                                  std::optional<Role> role, std::string_view peer, std::string_view key) {
  peer_ = peer;
  key_ = key;
  if (!role) {
    rejected();
    return Refusal{"this key is not admitted here any more"};
  }
  const Expected<ClientMessage> message = decode_client_message(bytes);
  if (!message) {
    rejected();
    return Refusal{message.error().message};
  }
  return std::visit([&](const auto& body) { return answer(body, received, *role); }, *message);
}

ServiceCore::Client* ServiceCore::find(std::uint64_t id) {
  const auto client =
      std::find_if(clients_.begin(), clients_.end(), [&](const Client& c) { return c.id == id; });
  return client == clients_.end() ? nullptr : &*client;
}

ServiceCore::Client* ServiceCore::admit(std::uint64_t id, Instant<PhysicsClock> now, Role role) {
  if (Client* known = find(id)) return known;
  const auto lives = [now](const Client& c) { return c.id != 0 && now - c.heard <= kClientGoneAfter; };
  const auto here = std::find_if(clients_.begin(), clients_.end(), [&](const Client& c) {
    return lives(c) && !peer_.empty() && c.peer == peer_;
  });
  if (here != clients_.end()) return &(*here = {.id = id});
  const auto of_key = std::count_if(clients_.begin(), clients_.end(), [&](const Client& c) {
    return lives(c) && !key_.empty() && c.key == key_;
  });
  if (of_key >= static_cast<std::ptrdiff_t>(kMaxClientsOfKey)) return nullptr;
  const std::size_t most = role == Role::operator_ ? kMaxClients : kMaxClients - kForOperators;
  if (std::count_if(clients_.begin(), clients_.end(), lives) >= static_cast<std::ptrdiff_t>(most))
    return nullptr;
  Client* place = find(0);
  if (place == nullptr) {
    place = &*std::min_element(clients_.begin(), clients_.end(),
                               [](const Client& a, const Client& b) { return a.heard < b.heard; });
    if (now - place->heard <= kClientGoneAfter) return nullptr;
  }
  *place = {.id = id};
  return place;
}

ServerMessage ServiceCore::answer(const Hello& message, Instant<PhysicsClock> received, Role role) {
  Client* client = admit(message.client, received, role);
  if (client == nullptr) {
    rejected();
    return Refusal{
        fmt::format("too many clients are connected; this server takes {}, of them {} with the same key; the "
                    "last {} places are for operators",
                    kMaxClients, kMaxClientsOfKey, kForOperators)};
  }
  client->heard = received;
  client->peer = peer_;
  client->key = key_;
  client->told = {message.name, role, message.figures.value_or(ClientFigures{})};
  count_clients();
  if (message.known_session == session_) return Welcome{session_, std::nullopt, role, states_};
  return Welcome{session_, scene_, role, states_};
}

ServerMessage ServiceCore::answer(const StateRequest& message, Instant<PhysicsClock>, Role) {
  requests_.fetch_add(1, std::memory_order_relaxed);
  StateReply reply{message.number, message.time, source_(message.time), nullptr};
  if (!message.shape || scene_.shape_vertices == 0 || !shape_source_) return reply;
  const auto shape = shapes_.take(peer_);
  if (!shape) {
    unsent();
    return reply;
  }
  if (const auto time = shape_source_(message.time, shape->values)) {
    shape->time = *time;
    reply.shape = shape;
  }
  return reply;
}

void ServiceCore::set_shape_source(ShapeSource source) {
  shape_source_ = std::move(source);
  shapes_ = ShapePool(scene_.shape_vertices);
}

ServerMessage ServiceCore::answer(const SyncRequest& message, Instant<PhysicsClock> received, Role) {
  syncs_.fetch_add(1, std::memory_order_relaxed);
  return SyncReply{message.number, received, now_()};
}

ServerMessage ServiceCore::answer(const ControlCall& message, Instant<PhysicsClock>, Role role) {
  if (!may(role, message.control)) {
    rejected();
    return ControlReply{message.number,
                        fmt::format("the role of this key is {}, which may not do that", role_name(role))};
  }
  Client* client = find(message.client);
  if (client == nullptr) return Refusal{"a control call needs a Hello before it"};
  if (message.number > client->last_control) {
    if (!controls_.push(message.control))
      return Refusal{"too many control calls are waiting; it will be tried again"};
    client->last_control = message.number;
    control_count_.fetch_add(1, std::memory_order_relaxed);
  }
  return ControlReply{message.number, {}};
}

ServerMessage ServiceCore::answer(const StatusRequest& message, Instant<PhysicsClock> received, Role) {
  ServerStatus status = status_ ? status_() : ServerStatus{};
  status.application = scene_.application;
  for (const auto& client : clients_)
    if (client.id != 0 && received - client.heard <= kClientGoneAfter) status.clients.push_back(client.told);
  const ServiceCounters set_counts = counters();
  status.requests = set_counts.requests;
  status.syncs = set_counts.syncs;
  status.controls = set_counts.controls;
  status.rejected = set_counts.rejected;
  status.unsent = set_counts.unsent;
  status.rejected_connections = rejected_connections_;
  status.published = published_;
  return StatusReply{message.number, std::move(status)};
}

ServerMessage ServiceCore::answer(const Subscribe&, Instant<PhysicsClock>, Role) {
  rejected();
  if (states_.empty()) return Refusal{"this server sends no states by itself; ask for each"};
  return Refusal{fmt::format("subscriptions are taken at the states' address, {}", states_)};
}

void ServiceCore::count_clients() {
  const Instant<PhysicsClock> now = now_();
  client_count_.store(static_cast<int>(std::count_if(
                          clients_.begin(), clients_.end(),
                          [&](const Client& c) { return c.id != 0 && now - c.heard <= kClientGoneAfter; })),
                      std::memory_order_relaxed);
}

std::optional<scene::Control> ServiceCore::take_control() {
  scene::Control control = scene::Control::none;
  if (!controls_.pop(control)) return std::nullopt;
  return control;
}

ServiceCounters ServiceCore::counters() const {
  return {.clients = client_count_.load(std::memory_order_relaxed),
          .requests = requests_.load(std::memory_order_relaxed),
          .syncs = syncs_.load(std::memory_order_relaxed),
          .controls = control_count_.load(std::memory_order_relaxed),
          .rejected = rejected_.load(std::memory_order_relaxed),
          .unsent = unsent_.load(std::memory_order_relaxed)};
}

}  // namespace palpate::transport
