// The graphics server's ZeroMQ socket. The graphics loop sends by itself (no second thread to be woken on the
// way out); a thread waits for replies so that each is stamped when it comes, however busy the loop is. Both
// reach the socket under one mutex, held for a few non-blocking calls; the loop takes what has come from a
// queue without it.
#include <poll.h>
#include <zmq.h>

#include <mutex>
#include <thread>

#include "palpate/network/handover_queue.h"
#include "palpate/network/zmq_engine.h"
#include "palpate/network/zmq_socket.h"

namespace palpate {

namespace {

class ZmqWire : public LinkWire {
 public:
  ZmqWire(zmq::Socket socket, const Clock<GraphicsClock>& clock)
      : socket_(std::move(socket)), clock_(clock), thread_([this] { run(); }) {}
  ~ZmqWire() override {
    stop_.set();
    thread_.join();
  }
  ZmqWire(const ZmqWire&) = delete;
  ZmqWire& operator=(const ZmqWire&) = delete;

  Instant<GraphicsClock> now() const override { return clock_.now(); }

  std::optional<Instant<GraphicsClock>> send(const ClientMessage& message) override {
    const std::string bytes = encode(message);
    const std::lock_guard lock(mutex_);
    const Instant<GraphicsClock> sent = clock_.now();
    const bool left = socket_.send(bytes);
    // Sending may have swallowed the signal that something has come; the thread would then sleep over it.
    receive_all();
    if (!left) return std::nullopt;
    return sent;
  }

  bool take(Arrival& arrival) override { return arrivals_.pop(arrival); }

 private:
  void run() {
    pthread_setname_np(pthread_self(), "palpate-link");
    pollfd items[] = {{socket_.fd(), POLLIN, 0}, {stop_.fd(), POLLIN, 0}};
    while (true) {
      // The time-out is a safety net; each signal of the socket wakes the thread.
      ::poll(items, 2, 100);
      if ((items[1].revents & POLLIN) != 0) return;
      const std::lock_guard lock(mutex_);
      receive_all();
    }
  }

  // With the mutex held: it makes the two threads one writer of the queue.
  void receive_all() {
    while (socket_.readable()) {
      const auto received = socket_.receive(1, nullptr, body_);
      if (received == zmq::Socket::Received::nothing) return;
      Arrival arrival{clock_.now(), std::nullopt};
      if (received == zmq::Socket::Received::message) {
        if (auto message = decode_server_message(body_)) arrival.message = std::move(*message);
      }
      // Full when the graphics loop has stopped for seconds; what is dropped then is counted as lost.
      arrivals_.push(std::move(arrival));
    }
  }

  zmq::Socket socket_;
  const Clock<GraphicsClock>& clock_;
  std::mutex mutex_;
  std::string body_;
  HandoverQueue<Arrival, 128> arrivals_;
  zmq::Stop stop_;
  std::thread thread_;
};

}  // namespace

Expected<std::unique_ptr<StateLink>> connect_states(const Endpoint& endpoint,
                                                    const Clock<GraphicsClock>& clock, std::string name) {
  auto socket = zmq::Socket::make(ZMQ_DEALER);
  if (!socket) return tl::unexpected(socket.error());
  if (zmq_connect(socket->get(), endpoint.address.c_str()) != 0) {
    return refused("{}: cannot connect there: {}", endpoint.address, zmq_strerror(errno));
  }
  try {
    return std::make_unique<StateLink>(std::make_unique<ZmqWire>(std::move(*socket), clock),
                                       zmq::new_name("network/client"), std::move(name));
  } catch (const std::exception& failure) {
    return refused("{}: the link cannot start: {}", endpoint.address, failure.what());
  }
}

}  // namespace palpate
