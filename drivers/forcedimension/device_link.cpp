#include "drivers/forcedimension/device_link.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/device/arm_kinematics.h"

namespace palpate::drivers::forcedimension {
namespace {

constexpr const char* kHowToReach =
    "plug it in, switch it on, end other programs that use it, and let this user open it (a udev rule for "
    "USB vendor "
    "1451, of a Falcon 0403)";

constexpr int kStatusEvery = 8;    // exchanges
constexpr int kEnableEvery = 200;  // exchanges, while the device has its forces off for our being late

using device::HealthCode;
constexpr arms::Complaint kNoZero{
    HealthCode::arm_uncalibrated,
    "does not know where it is; put its handle to its rest place as the maker's "
    "manual shows, or run the maker's calibration"};
constexpr arms::Complaint kNoWrist{HealthCode::arm_uncalibrated,
                                   "does not know how its wrist is turned; run the maker's calibration"};
constexpr arms::Complaint kNoPower{HealthCode::arm_forces_off,
                                   "has no power for its motors; plug its supply in and switch it on"};
constexpr arms::Complaint kFault{HealthCode::arm_forces_off,
                                 "its controller reports an error; switch it off and on again"};
constexpr arms::Complaint kButton{HealthCode::arm_forces_off,
                                  "its forces are off; press its force button to have them back"};
constexpr arms::Complaint kTooFast{
    HealthCode::arm_forces_off,
    "has switched its forces off, as it was moved too fast; press its force button"};
constexpr arms::Complaint kNotHeld{
    HealthCode::arm_forces_off, "has switched its forces off, as nobody holds it; take hold of its handle"};
constexpr arms::Complaint kLate{
    HealthCode::arm_forces_off,
    "has switched its forces off, as this program was late; they come back by themselves"};

std::string text_of(const char* text) { return text == nullptr ? "" : excerpt(text); }

// As published for its kind: Force Dimension's data sheets by way of CHAI3D 3.3 (CDeltaDevices.cpp).
double published_peak_n(int type) {
  if (type == dhd::kTypeDelta3) return 20.0;
  return type == dhd::kTypeFalcon ? 8.0 : 12.0;
}

bool is_arm(int type) {
  return type > dhd::kTypeNone && type != dhd::kTypeController && type != dhd::kTypeControllerHr;
}

bool is_rotation(const Matrix3& R) {
  constexpr double kTolerance = 1e-3;
  return R.allFinite() && (R * R.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff() < kTolerance &&
         R.determinant() > 0.0;
}

class DeviceLink : public arms::ArmLink {
 public:
  DeviceLink(OpenDevice device, KnownDevice& known) : device_(std::move(device)), known_(known) {}

  Expected<arms::ExchangedState> exchange(const Vector3& asked) override {
    arms::ExchangedState state;
    const double peak = device_.facts().peak_n;
    const Vector3 force = asked.norm() > peak ? Vector3(asked * (peak / asked.norm())) : asked;
    if (exchanges_++ % kStatusEvery == 0)
      if (auto fine = look_at_status(); !fine) return tl::unexpected(fine.error());
    const std::int64_t begun = arms::now_ns();
    double rotation[3][3] = {};
    Vector3 place = Vector3::Zero();
    if (dhd().get_pose(&place.x(), &place.y(), &place.z(), rotation, device_.id()) < 0)
      return lost("its place cannot be read");
    // It was measured between the two.
    state.reading.stamp_ns = begun + (arms::now_ns() - begun) / 2;
    const int answer = dhd().set_force(force.x(), force.y(), force.z(), 0.0, 0.0, 0.0, 0.0, device_.id());
    if (answer < 0) return lost("a force cannot be commanded");
    const bool saturated = answer == dhd::kMotorSaturated;
    if (saturated) known_.saturations.fetch_add(1, std::memory_order_relaxed);

    const Matrix3 R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&rotation[0][0]);
    state.knows_its_place = knows_its_place_ && place.allFinite() && is_rotation(R);
    state.may_push = forces_on_;
    state.complaint = complaint_;
    if (!forces_on_)
      state.held = Vector3::Zero();
    else if (!saturated)
      state.held = force;
    state.reading.joints = {place.x(), place.y(), place.z()};
    state.reading.buttons = dhd().get_button_mask(device_.id());
    if (!device_.facts().wrist || !state.knows_its_place) return state;
    const Vector3 gimbal = device::gimbal_angles(Quaternion(R).normalized());
    state.reading.gimbal = {gimbal.x(), gimbal.y(), gimbal.z()};
    return state;
  }

 private:
  const dhd::Functions& dhd() const { return device_.dhd(); }

  tl::unexpected<Error> lost(const char* what) const {
    return refused("{} {}: {} ({}); see to its cable and power", device_.facts().model,
                   device_.facts().serial, what, text_of(dhd().get_last_error()));
  }

  Expected<void> look_at_status() {
    std::array<int, dhd::kMostStatus> status{};
    if (dhd().get_status(status.data(), device_.id()) < 0) return lost("its state cannot be read");
    const auto is = [&](int slot) { return status[static_cast<std::size_t>(slot)] != 0; };
    if (!is(dhd::kConnected)) return lost("it is unplugged");
    const bool wrist_lost = device_.facts().wrist && is(dhd::kWristDetected) && !is(dhd::kWristInit);
    knows_its_place_ = !is(dhd::kReset) && !wrist_lost;
    forces_on_ = is(dhd::kPower) && is(dhd::kForce) && !is(dhd::kError);
    complaint_ = nullptr;
    if (is(dhd::kReset))
      complaint_ = &kNoZero;
    else if (wrist_lost)
      complaint_ = &kNoWrist;
    else if (!is(dhd::kPower))
      complaint_ = &kNoPower;
    else if (is(dhd::kError))
      complaint_ = &kFault;
    else if (!is(dhd::kForce))
      complaint_ = why_off(status[dhd::kForceOffCause]);
    const bool ours = complaint_ == &kLate;
    if (ours && exchanges_ - enabled_at_ >= kEnableEvery) {
      enabled_at_ = exchanges_;
      dhd().enable_force(1, device_.id());
    }
    return {};
  }

  static const arms::Complaint* why_off(int cause) {
    switch (cause) {
      case dhd::kOffVelocity:
        return &kTooFast;
      case dhd::kOffDeadMan:
        return &kNotHeld;
      case dhd::kOffWatchdog:
        return &kLate;
      default:
        return &kButton;
    }
  }

  OpenDevice device_;
  KnownDevice& known_;
  std::uint64_t exchanges_ = 0, enabled_at_ = 0;
  bool knows_its_place_ = false, forces_on_ = false;
  const arms::Complaint* complaint_ = nullptr;
};

}  // namespace

OpenDevice::OpenDevice(std::shared_ptr<Library> library, int id)
    : library_(std::move(library)), id_(static_cast<char>(id)) {
  const int type = dhd().get_system_type(id_);
  unsigned short serial = 0;
  static_cast<void>(dhd().get_serial_number(&serial, id_));  // 0: older ones have none
  facts_.serial = serial;
  facts_.model = text_of(dhd().get_system_name(id_));
  facts_.library = library_->facts().file;
  facts_.library_version = library_->facts().version;
  facts_.wrist = dhd().has_wrist != nullptr && dhd().has_wrist(id_);
  facts_.left_handed = dhd().is_left_handed != nullptr && dhd().is_left_handed(id_);
  facts_.peak_n = published_peak_n(type);
  const double stated = dhd().get_max_force != nullptr ? dhd().get_max_force(id_) : -1.0;
  if (stated >= 0.0) facts_.peak_n = std::min(facts_.peak_n, stated);
}

OpenDevice::OpenDevice(OpenDevice&& other) noexcept
    : library_(std::move(other.library_)), id_(other.id_), facts_(std::move(other.facts_)) {}

OpenDevice::~OpenDevice() {
  if (!library_) return;
  static_cast<void>(dhd().set_force(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, id_));
  static_cast<void>(dhd().enable_force(0, id_));
  const std::lock_guard lock(library_->opening());
  static_cast<void>(dhd().close(id_));
  library_->open_ids().erase(id_);
}

Expected<OpenDevice> OpenDevice::find(std::shared_ptr<Library> library, std::optional<int> serial) {
  const auto& dhd = library->dhd();
  const std::string wanted = serial ? fmt::format("device {}", *serial) : std::string("device");
  std::string seen, failed;
  std::unique_lock lock(library->opening());
  const int count = dhd.get_device_count();
  for (int index = 0; index < count; ++index) {
    const int id = dhd.open_id(static_cast<char>(index));
    if (id < 0) {
      failed = text_of(dhd.get_last_error());
      continue;
    }
    if (library->open_ids().contains(id)) {  // of another arm of this program
      failed = "this program uses it already";
      continue;
    }
    library->open_ids().insert(id);
    OpenDevice device(library, id);
    if (is_arm(dhd.get_system_type(device.id())) && (!serial || device.facts().serial == *serial))
      return device;
    seen += fmt::format("{}{} {}", seen.empty() ? "" : ", ", device.facts().model, device.facts().serial);
    lock.unlock();  // for giving it back
    { const OpenDevice back(std::move(device)); }
    lock.lock();
  }
  if (count <= 0) return refused("there is no {}; {}", wanted, kHowToReach);
  if (!failed.empty())
    return refused("no {} can be opened ({}){}; {}", wanted, failed, seen.empty() ? "" : ", there is " + seen,
                   kHowToReach);
  return refused("there is no {}, but {}; name one of these or plug it in", wanted, seen);
}

bool OpenDevice::start_watchdog() {
  const auto& functions = dhd();
  if (functions.enable_expert_mode == nullptr || functions.disable_expert_mode == nullptr ||
      functions.set_watchdog == nullptr)
    return false;
  const auto units = static_cast<unsigned char>(to_seconds(device::kLongestHold) / dhd::kWatchdogUnit);
  const bool expert = functions.enable_expert_mode() >= 0;
  facts_.watchdog = expert && functions.set_watchdog(units, id_) >= 0;
  if (expert) functions.disable_expert_mode();
  return facts_.watchdog;
}

Expected<std::unique_ptr<arms::ArmLink>> open_device(KnownDevice& known) {
  auto device = OpenDevice::find(known.library, known.serial);
  if (!device) return tl::unexpected(device.error());
  // Its calibration and the check of its forces are the first one's.
  if (known.facts &&
      (device->facts().model != known.facts->model || device->facts().serial != known.facts->serial))
    return refused(
        "the arm that came back is {} {}, and was {} {}; plug that one in, or start the server anew",
        device->facts().model, device->facts().serial, known.facts->model, known.facts->serial);
  device->start_watchdog();
  // With a force of 0 first: it is one that switches a device to giving some.
  if (device->dhd().enable_force(1, device->id()) < 0 ||
      device->dhd().set_force(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, device->id()) < 0)
    return refused("{} {}: its forces cannot be switched on ({}); {}", device->facts().model,
                   device->facts().serial, text_of(device->dhd().get_last_error()), kHowToReach);
  if (!known.facts) known.facts = device->facts();  // before whoever opens it goes on
  return std::make_unique<DeviceLink>(std::move(*device), known);
}

}  // namespace palpate::drivers::forcedimension
