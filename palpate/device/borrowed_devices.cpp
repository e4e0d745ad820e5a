#include "palpate/device/borrowed_devices.h"

#include <utility>

namespace palpate::device {
namespace {

template <typename Base, typename Device>
class Borrowed : public Base {
 public:
  explicit Borrowed(Device& device) : device_(device) {}
  Device& device() override { return device_; }

 private:
  Device& device_;
};

class BorrowedArm : public Borrowed<OpenedArm, ArmDevice> {
 public:
  BorrowedArm(ArmDevice& arm, ArmFacts facts) : Borrowed(arm), facts_(std::move(facts)) {}
  ArmFacts facts() const override { return facts_; }

 private:
  ArmFacts facts_;
};

class BorrowedCamera : public Borrowed<OpenedCamera, CameraDevice> {
 public:
  BorrowedCamera(std::string name, const BorrowedDevices& devices)
      : Borrowed(*devices.camera),
        name_(std::move(name)),
        simulated_(devices.simulated),
        right_(devices.right_camera) {}
  bool simulated() const override { return simulated_; }
  std::string name() const override { return name_; }
  std::string description() const override { return "the program's own"; }
  Expected<CameraDevice*> right() override { return right_; }

 private:
  std::string name_;
  bool simulated_;
  CameraDevice* right_;
};

// An opener of one device; nothing where there is none.
template <typename O, typename Make>
std::optional<O> opener(bool there, const std::string& scheme, Make make) {
  if (!there) return std::nullopt;
  O result;
  result.form = scheme;
  result.names = [scheme](std::string_view uri) { return uri == scheme; };
  result.open =
      [make = std::move(make)](const typename O::Request&) -> Expected<std::unique_ptr<typename O::Opened>> {
    return make();
  };
  return result;
}

}  // namespace

Driver borrowed_devices(const std::string& scheme, const BorrowedDevices& devices) {
  Driver driver;
  driver.scheme = scheme;
  driver.summary = "devices of this program's own";
  driver.simulated = devices.simulated;
  driver.arm = opener<ArmOpener>(devices.arm != nullptr, scheme, [devices] {
    return std::make_unique<BorrowedArm>(*devices.arm, devices.arm_facts);
  });
  driver.tracker = opener<TrackerOpener>(devices.tracker != nullptr, scheme, [devices] {
    return std::make_unique<Borrowed<OpenedTracker, TrackerDevice>>(*devices.tracker);
  });
  driver.camera = opener<CameraOpener>(devices.camera != nullptr, scheme, [scheme, devices] {
    return std::make_unique<BorrowedCamera>(scheme, devices);
  });
  driver.hand = opener<HandOpener>(devices.hand != nullptr, scheme, [devices] {
    return std::make_unique<Borrowed<OpenedHand, HandDevice>>(*devices.hand);
  });
  driver.display = opener<DisplayOpener>(devices.display != nullptr, scheme, [devices] {
    return std::make_unique<Borrowed<OpenedDisplay, DisplayDevice>>(*devices.display);
  });
  return driver;
}

}  // namespace palpate::device
