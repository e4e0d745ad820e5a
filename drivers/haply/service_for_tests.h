// A service as the maker's documentation describes it, over a real socket of this machine: one arm, one grip, and faults.
#pragma once

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/math/so3.h"

namespace palpate::drivers::haply {

class ServiceForTests {
 public:
  struct Faults {
    bool tells_config = true, has_arm = true, calibrated = true, powered = true, talks_nonsense = false;
    std::string axes = "XYZ";
    double mounted_at_x = 0.0;
  };

  explicit ServiceForTests(std::uint16_t port = 0)
      : acceptor_(context_, {boost::asio::ip::make_address("127.0.0.1"), port}),
        port_(acceptor_.local_endpoint().port()),
        thread_([this] { serve(); }) {}
  ~ServiceForTests() {
    ending_ = true;
    hang_ = false;
    drop();
    boost::system::error_code ignored;
    // Wakes accept().
    boost::asio::io_context context;
    boost::asio::ip::tcp::socket(context).connect({boost::asio::ip::make_address("127.0.0.1"), port_},
                                                  ignored);
    thread_.join();
  }

  std::uint16_t port() const { return port_; }
  void set(const Faults& faults) {
    const std::lock_guard lock(guard_);
    faults_ = faults;
  }
  void move_to(const Vector3& place, const Quaternion& grip = Quaternion::Identity(), bool button_b = false) {
    const std::lock_guard lock(guard_);
    place_ = place, grip_ = grip, button_b_ = button_b;
  }
  // Says nothing from now on.
  void hang(bool on) { hang_ = on; }
  // Ends the connection that there is.
  void drop() {
    const std::lock_guard lock(guard_);
    if (client_ != nullptr) ::shutdown(client_->native_handle(), SHUT_RDWR);
  }

  std::uint64_t commands() const { return commands_; }
  std::uint64_t connections() const { return connections_; }
  Vector3 force() const {  // of the newest command
    const std::lock_guard lock(guard_);
    return force_;
  }
  double largest_force() const {
    const std::lock_guard lock(guard_);
    return largest_;
  }
  std::vector<Json> configured() const {
    const std::lock_guard lock(guard_);
    return configured_;
  }

 private:
  using Socket = boost::asio::ip::tcp::socket;

  void serve() {
    while (!ending_) {
      boost::system::error_code failed;
      Socket socket(context_);
      acceptor_.accept(socket, failed);
      if (failed || ending_) return;
      {
        const std::lock_guard lock(guard_);
        client_ = &socket;
      }
      ++connections_;
      try {
        talk(socket);
      } catch (const boost::system::system_error&) {
      }
      const std::lock_guard lock(guard_);
      client_ = nullptr;
    }
  }

  void talk(Socket& socket) {
    boost::beast::websocket::stream<Socket&> stream(socket);
    stream.accept();
    stream.text(true);
    const auto say = [&](bool full) {
      const std::string text = state(full);
      stream.write(boost::asio::buffer(text));
    };
    say(true);
    while (!ending_) {
      boost::beast::flat_buffer buffer;
      stream.read(buffer);
      const bool full = hear(boost::beast::buffers_to_string(buffer.data()));
      while (hang_ && !ending_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      say(full);
    }
  }

  // True where the whole state is asked for.
  bool hear(const std::string& text) {
    const Json json = Json::parse(text);
    const std::lock_guard lock(guard_);
    for (const auto& device : json.value("inverse3", Json::array())) {
      if (device.contains("configure")) configured_.push_back(device["configure"]);
      const Json v = device["commands"]["set_cursor_force"]["vector"];
      force_ = Vector3(v["x"], v["y"], v["z"]);
      largest_ = std::max(largest_, force_.norm());
      ++commands_;
    }
    return json.contains("session") && json["session"].contains("force_render_full_state");
  }

  std::string state(bool full) {
    const std::lock_guard lock(guard_);
    if (faults_.talks_nonsense) return "{\"inverse3\": [{\"device_id\": 7}]}";
    const auto xyz = [](const Vector3& v) { return Json{{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; };
    Json arm = {
        {"device_id", "049D"},
        {"state",
         {{"cursor_position", xyz(place_)},
          {"cursor_velocity", xyz(Vector3::Zero())},
          {"angular_position", {{"a0", 0.0}, {"a1", 0.0}, {"a2", 0.0}}},
          {"current_cursor_force", xyz(force_)},
          {"control_mode", "force"}}},
        {"status", {{"calibrated", faults_.calibrated}, {"power_supply", faults_.powered}, {"ready", true}}}};
    if (full && faults_.tells_config)
      arm["config"] = {{"type", "inverse3"},
                       {"basis", {{"permutation", faults_.axes}}},
                       {"mount",
                        {{"position", xyz({faults_.mounted_at_x, 0.0, 0.0})},
                         {"rotation", {{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 0.0}}},
                         {"scale", xyz(Vector3::Ones())}}},
                       {"filters", {{"force_gate", {{"gain", 0.3}}}}}};
    Json json = {{"session_id", 7}, {"inverse3", Json::array()}};
    if (faults_.has_arm) json["inverse3"].push_back(arm);
    json["wireless_verse_grip"] = Json::array(
        {{{"device_id", "61576"},
          {"state",
           {{"orientation", {{"w", grip_.w()}, {"x", grip_.x()}, {"y", grip_.y()}, {"z", grip_.z()}}},
            {"buttons", {{"a", false}, {"b", button_b_}, {"c", false}}}}}}});
    return json.dump();
  }

  boost::asio::io_context context_;
  boost::asio::ip::tcp::acceptor acceptor_;
  std::uint16_t port_;
  mutable std::mutex guard_;
  Faults faults_;
  Socket* client_ = nullptr;
  Vector3 place_{0.0, -0.12, 0.15}, force_ = Vector3::Zero();
  double largest_ = 0.0;
  Quaternion grip_ = Quaternion::Identity();
  bool button_b_ = false;
  std::vector<Json> configured_;
  std::atomic<bool> ending_{false}, hang_{false};
  std::atomic<std::uint64_t> commands_{0}, connections_{0};
  std::thread thread_;
};

}  // namespace palpate::drivers::haply
