#include "palpate/transport/probe.h"

#include <google/protobuf/stubs/common.h>
#include <zmq.h>

#include <cerrno>
#include <thread>

#include "palpate/core/system_error.h"
#include "palpate/transport/messages.h"
#include "palpate/transport/zmq_engine.h"
#include "palpate/transport/zmq_socket.h"

namespace palpate::transport {

NetworkLibraries network_libraries() {
  NetworkLibraries libraries;
  int major = 0, minor = 0, patch = 0;
  zmq_version(&major, &minor, &patch);
  libraries.zeromq = fmt::format("{}.{}.{}", major, minor, patch);
  libraries.curve = zmq_has("curve") == 1;
  libraries.protobuf = google::protobuf::internal::VersionString(GOOGLE_PROTOBUF_VERSION);
  libraries.protocol = kProtocol;
  return libraries;
}

Expected<Answered> who_answers(const Endpoint& endpoint, const std::optional<ClientIdentity>& identity,
                               double patience_s) {
  if (endpoint.local() && !somebody_listens(endpoint.socket)) return Answered{};
  const MonotonicClock<GraphicsClock> clock;
  auto link = connect_states(endpoint, clock, "doctor", identity);
  if (!link) return tl::unexpected(link.error());
  const auto start = clock.now();
  // The first attempt may fail while the other side still closes an earlier one, so trouble alone is no end.
  while (to_seconds(clock.now() - start) < patience_s) {
    (*link)->poll();
    if ((*link)->role()) return Answered{Answer::physics_server, (*link)->role(), {}};
    if ((*link)->trouble_kind() == LinkTrouble::not_admitted)
      return Answered{Answer::not_admitted, {}, *(*link)->trouble()};
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  Answered answered;
  answered.trouble = (*link)->trouble().value_or("");
  if (endpoint.local() || !answered.trouble.empty()) answered.who = Answer::stranger;
  return answered;
}

Listening can_listen(const Endpoint& endpoint) {
  Listening listening;
  auto socket = zmq::Socket::make(ZMQ_ROUTER);
  if (!socket) {
    listening.reason = socket.error().message;
  } else if (zmq_bind(socket->get(), endpoint.address.c_str()) == 0) {
    listening.possible = true;
  } else {
    listening.in_use = errno == EADDRINUSE;
    listening.reason = reason_of(errno);
  }
  return listening;
}

}  // namespace palpate::transport
