#include "drivers/laboratory/driver.h"

#include <fmt/format.h>

#include <map>
#include <mutex>

#include "drivers/laboratory/channel.h"
#include "drivers/laboratory/memory.h"

namespace palpate::drivers::laboratory {
namespace {

using Client = std::shared_ptr<LabClient>;

// One client of each laboratory, shared by the devices that are open at a time.
class Clients {
 public:
  Expected<Client> open(std::string_view uri) {
    const std::string rest(device::rest_of(uri));
    const std::string name = rest.empty() ? "lab" : rest;
    const std::lock_guard lock(mutex_);
    if (auto open = clients_[name].lock()) return open;
    auto client = LabClient::open(name);
    if (client) clients_[name] = *client;
    return client;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<LabClient>> clients_;
};

// A device of a laboratory: gone when that is.
template <typename Base, typename Device, typename Mine>
class OpenedLab : public Base {
 public:
  OpenedLab(Client client, std::unique_ptr<Mine> device)
      : client_(std::move(client)), device_(std::move(device)) {}
  Device& device() override { return *device_; }
  Expected<void> look() override { return client_->check(); }

 protected:
  Client client_;
  std::unique_ptr<Mine> device_;
};

class OpenedLabArm : public OpenedLab<device::OpenedArm, device::ArmDevice, LabArm> {
 public:
  using OpenedLab::OpenedLab;
  std::optional<device::HealthReport> health() override {
    if (!client_->silent()) return std::nullopt;
    return device::HealthReport{
        device::HealthCode::laboratory_silent,
        fmt::format("laboratory '{}' stands still: no forces until it goes on", client_->name()),
        fmt::format("laboratory '{}' goes on", client_->name())};
  }
  device::ArmFacts facts() const override {
    return {.simulated = true,
            .identity = "lab",
            .states_place = client_->states_place(),
            .peak_n = {},
            .continuous_n = {}};
  }
};

class OpenedLabCamera : public OpenedLab<device::OpenedCamera, device::CameraDevice, LabCamera> {
 public:
  using OpenedLab::OpenedLab;
  bool simulated() const override { return true; }
  std::string name() const override { return "lab:" + client_->name(); }
  std::string description() const override { return "camera of a simulated laboratory"; }
  Expected<device::CameraDevice*> right() override {
    if (right_ || client_->cameras() < 2) return right_.get();
    auto opened = LabCamera::open(client_, 1);
    if (!opened) return tl::unexpected(opened.error());
    right_ = std::move(*opened);
    return right_.get();
  }

 private:
  std::unique_ptr<LabCamera> right_;
};

using OpenedLabTracker = OpenedLab<device::OpenedTracker, device::TrackerDevice, LabTracker>;
using OpenedLabHand = OpenedLab<device::OpenedHand, device::HandDevice, LabHand>;
using OpenedLabDisplay = OpenedLab<device::OpenedDisplay, device::DisplayDevice, LabDisplay>;

// Opens with the laboratory of the request.
template <typename Opened, typename Mine, typename Opener, typename Open>
Opener opener(const std::shared_ptr<Clients>& clients, Open open) {
  using Request = typename Opener::Request;
  using Result = Expected<std::unique_ptr<typename Opener::Opened>>;
  Opener made;
  made.form = "lab";
  made.open = [clients, open](const Request& request) -> Result {
    auto client = clients->open(request.uri);
    if (!client) return tl::unexpected(client.error());
    Expected<std::unique_ptr<Mine>> device = open(*client);
    if (!device) return tl::unexpected(device.error());
    return std::make_unique<Opened>(*client, std::move(*device));
  };
  return made;
}

}  // namespace

void add_to(device::DriverRegistry& registry) {
  const auto clients = std::make_shared<Clients>();
  device::Driver driver;
  driver.scheme = "lab";
  driver.summary = "the devices of a simulated laboratory";
  driver.simulated = true;
  driver.arm = opener<OpenedLabArm, LabArm, device::ArmOpener>(
      clients, [](const Client& client) { return LabArm::open(client); });
  driver.tracker =
      opener<OpenedLabTracker, LabTracker, device::TrackerOpener>(clients, [](const Client& client) {
        return Expected<std::unique_ptr<LabTracker>>(std::make_unique<LabTracker>(client));
      });
  driver.camera = opener<OpenedLabCamera, LabCamera, device::CameraOpener>(
      clients, [](const Client& client) { return LabCamera::open(client); });
  driver.hand = opener<OpenedLabHand, LabHand, device::HandOpener>(
      clients, [](const Client& client) { return LabHand::open(client); });
  driver.display = opener<OpenedLabDisplay, LabDisplay, device::DisplayOpener>(
      clients, [](const Client& client) { return LabDisplay::open(client); });
  registry.add(std::move(driver));
}

bool is_there(const std::string& name) {
  const auto file = file_of(name, {});
  std::error_code code;
  return file && std::filesystem::exists(*file, code);
}

}  // namespace palpate::drivers::laboratory
