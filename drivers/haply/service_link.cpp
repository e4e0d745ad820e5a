#include "drivers/haply/service_link.h"

#include "drivers/haply/protocol.h"
#include "palpate/core/text.h"
#include "palpate/device/arm_kinematics.h"

namespace palpate::drivers::haply {
namespace {

using namespace std::chrono_literals;

constexpr auto kAnswerWithin = 100ms, kConnectWithin = 1000ms;
constexpr int kInventoryAnswers = 50;  // after hello() the configuration comes within so many

constexpr arms::Complaint kUncalibrated{
    device::HealthCode::arm_uncalibrated,
    "is not calibrated; put the grip on the inkwell, or move the arm as its light asks for"};
constexpr arms::Complaint kUnpowered{device::HealthCode::arm_forces_off,
                                     "has no power for its motors; plug its supply in"};

std::array<double, 3> list(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

const ArmState* find(const ServiceState& state, const std::string& id) {
  for (const auto& arm : state.arms)
    if (id.empty() || arm.id == id) return &arm;
  return nullptr;
}

class ServiceLink : public arms::ArmLink {
 public:
  ServiceLink(std::unique_ptr<web::WebSocketClient> socket, std::string service, ToldByService& told)
      : socket_(std::move(socket)), service_(std::move(service)), told_(told) {}
  ~ServiceLink() override {
    static_cast<void>(socket_->send(force_command(told_.id, Vector3::Zero()), kAnswerWithin));
  }

  Expected<arms::ExchangedState> exchange(const Vector3& force) override {
    const std::int64_t begun = arms::now_ns();
    if (auto said = socket_->send(force_command(told_.id, force), kAnswerWithin); !said)
      return tl::unexpected(said.error());
    const auto text = socket_->receive(kAnswerWithin);
    if (!text) return tl::unexpected(text.error());
    const std::int64_t ended = arms::now_ns();
    const auto state = read_state(*text);
    if (!state) {
      told_.bad_states.fetch_add(1);
      return tl::unexpected(state.error());
    }
    const ArmState* arm = find(*state, told_.id);
    if (arm == nullptr) return refused("{}: the arm {} has gone; check its cable", service_, told_.id);
    // It was measured between the two.
    return state_of(*arm, *state, begun + (ended - begun) / 2);
  }

 private:
  static arms::ExchangedState state_of(const ArmState& arm, const ServiceState& all, std::int64_t stamp_ns) {
    arms::ExchangedState state;
    state.knows_its_place = arm.calibrated.value_or(true);
    state.may_push = arm.powered.value_or(true);
    state.complaint = !state.knows_its_place ? &kUncalibrated : state.may_push ? nullptr : &kUnpowered;
    state.held = arm.force;
    state.reading.stamp_ns = stamp_ns;
    state.reading.joints = list(arm.place);
    if (all.grips.empty()) return state;
    state.reading.gimbal = list(device::gimbal_angles(all.grips.front().orientation));
    state.reading.buttons = all.grips.front().buttons;
    return state;
  }

  std::unique_ptr<web::WebSocketClient> socket_;
  const std::string service_;
  ToldByService& told_;
};

Expected<ServiceState> next_state(web::WebSocketClient& socket) {
  const auto text = socket.receive(kConnectWithin);
  if (!text) return tl::unexpected(text.error());
  return read_state(*text);
}

}  // namespace

Expected<std::unique_ptr<arms::ArmLink>> connect_to_service(const web::WebSocketAddress& service,
                                                            ToldByService& told) {
  auto socket = web::WebSocketClient::connect(service, kConnectWithin);
  if (!socket) return tl::unexpected(socket.error());
  auto state = next_state(**socket);
  if (!state) return tl::unexpected(state.error());
  const ArmState* arm = find(*state, told.id);
  if (arm == nullptr)
    return refused("{}: the service has no {}; plug the arm in and switch it on", service.text(),
                   told.id.empty() ? std::string("Inverse3") : "Inverse3 " + told.id);
  const std::string id = arm->id;
  if (auto said = (*socket)->send(hello(id), kConnectWithin); !said) return tl::unexpected(said.error());
  for (int i = 0;; ++i) {
    state = next_state(**socket);
    if (!state) return tl::unexpected(state.error());
    arm = find(*state, id);
    if (arm == nullptr) return refused("{}: the arm {} has gone again; check its cable", service.text(), id);
    if (!arm->config.is_null() || i == kInventoryAnswers) break;
    if (auto said = (*socket)->send(force_command(id, Vector3::Zero()), kConnectWithin); !said)
      return tl::unexpected(said.error());
  }
  if (auto fine = check_configured(*arm); !fine) return tl::unexpected(fine.error());
  {
    const std::lock_guard lock(told.guard);
    told.config = arm->config;
  }
  if (told.id.empty()) told.id = id;  // before whoever opens it goes on
  return std::make_unique<ServiceLink>(std::move(*socket), service.text(), told);
}

}  // namespace palpate::drivers::haply
