// ZeroMQ by itself, DEALER to ROUTER, each side one thread that blocks: no clock, no look-up, no checks. What
// the engine below our exchange costs.
#pragma once

#include <zmq.h>

#include <cstring>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "palpate/transport/keys.h"

namespace palpate::bare_zeromq {

inline void set_text(void* socket, int option, const std::string& text) {
  zmq_setsockopt(socket, option, text.c_str(), text.size());
}

// Answers for ever. Each request's first eight bytes say how long the reply is to be.
inline void serve(const std::string& address, const std::optional<transport::KeyPair>& keys) {
  std::thread([address, keys] {
    void* socket = zmq_socket(zmq_ctx_new(), ZMQ_ROUTER);
    if (keys) {
      const int server = 1;
      zmq_setsockopt(socket, ZMQ_CURVE_SERVER, &server, sizeof server);
      set_text(socket, ZMQ_CURVE_SECRETKEY, keys->secret_key);
    }
    if (zmq_bind(socket, address.c_str()) != 0) return;
    std::vector<char> peer(256), request(1024), reply;
    while (true) {
      const int named = zmq_recv(socket, peer.data(), peer.size(), 0);
      const int asked = zmq_recv(socket, request.data(), request.size(), 0);
      if (named < 0 || asked < 8) continue;
      std::uint64_t size = 0;
      std::memcpy(&size, request.data(), sizeof size);
      if (reply.size() != size) reply.resize(size);
      zmq_send(socket, peer.data(), static_cast<std::size_t>(named), ZMQ_SNDMORE);
      zmq_msg_t frame;
      zmq_msg_init_data(
          &frame, reply.data(), reply.size(), [](void*, void*) {}, nullptr);
      zmq_msg_send(&frame, socket, 0);
    }
  }).detach();
}

class Client {
 public:
  Client(const std::string& address, const std::optional<transport::ClientIdentity>& identity)
      : socket_(zmq_socket(context_, ZMQ_DEALER)) {
    if (identity) {
      set_text(socket_, ZMQ_CURVE_PUBLICKEY, identity->own.public_key);
      set_text(socket_, ZMQ_CURVE_SECRETKEY, identity->own.secret_key);
      set_text(socket_, ZMQ_CURVE_SERVERKEY, identity->server_key);
    }
    zmq_connect(socket_, address.c_str());
  }
  Client(const Client&) = delete;
  ~Client() {
    zmq_close(socket_);
    zmq_ctx_destroy(context_);
  }

  // False where the reply is not the one asked for.
  bool exchange(const std::vector<char>& request, std::size_t reply_bytes) {
    zmq_msg_t reply;
    zmq_msg_init(&reply);
    const bool good = zmq_send(socket_, request.data(), request.size(), 0) >= 0 &&
                      zmq_msg_recv(&reply, socket_, 0) >= 0 && zmq_msg_size(&reply) == reply_bytes;
    zmq_msg_close(&reply);
    return good;
  }

 private:
  void* context_ = zmq_ctx_new();
  void* socket_;
};

}  // namespace palpate::bare_zeromq
