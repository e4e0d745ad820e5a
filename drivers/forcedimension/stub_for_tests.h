// For tests: the stand-in for libdhd.so, loaded as the driver loads it, and its simulated devices.
#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "drivers/forcedimension/arm.h"
#include "stub/dhd_stub.h"
#include "tests/comes_true.h"

namespace palpate::drivers::forcedimension {

inline const char* const kStub = DHD_STUB_DIR "/whole/libdhd.so";

using tests::comes_true;

class StubTest : public testing::Test {
 protected:
  // Reads or changes a device.
  template <typename Work>
  auto with(Work work, int number = 0) const {
    DhdStubDevice& device = *function<DhdStubDevice*(int)>("dhd_stub_device")(number);
    const std::lock_guard lock(device.guard);
    return work(device);
  }

  StubTest() {
    library_ = dlopen(kStub, RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) throw std::runtime_error(dlerror());
    function<void()>("dhd_stub_reset")();
    // Its own watchdog counts what a test says, not what a busy machine takes.
    for (int number = 0; number < 3; ++number) with([](DhdStubDevice& d) { d.clock_s = 0.0; }, number);
  }

  Vector3 force() const {
    return with([](DhdStubDevice& d) { return Vector3(d.force[0], d.force[1], d.force[2]); });
  }

  // Patient, so that a busy machine's hiccup does not count as the device's; without waits of its own.
  static ArmSettings patient() {
    ArmSettings settings;
    settings.library = kStub;
    settings.loop.watchdog_s = 10.0;
    settings.loop.ramp_s = 0.0;
    return settings;
  }
  static std::unique_ptr<ForceDimensionArm> opened(const ArmSettings& settings) {
    auto arm = ForceDimensionArm::open(settings);
    if (!arm) throw std::runtime_error(arm.error().message);
    return std::move(*arm);
  }
  static bool is(const ForceDimensionArm& arm, device::HealthCode code, const std::string& words) {
    const auto health = arm.status().health;
    return health && health->code == code && health->words.find(words) != std::string::npos;
  }
  static bool is_well(const ForceDimensionArm& arm) { return !arm.status().health; }

  // As the haptic loop does: again and again.
  template <typename Condition>
  static bool comes_true_while_pushing(ForceDimensionArm& arm, const Vector3& force, Condition&& condition) {
    return comes_true([&] {
      arm.command(force);
      return condition();
    });
  }
  bool gives(ForceDimensionArm& arm, const Vector3& asked) const {
    return comes_true_while_pushing(arm, asked, [&] { return (force() - asked).norm() < 1e-12; });
  }

 private:
  template <typename Function>
  std::add_pointer_t<Function> function(const char* name) const {
    return reinterpret_cast<std::add_pointer_t<Function>>(dlsym(library_, name));
  }
  void* library_ = nullptr;
};

}  // namespace palpate::drivers::forcedimension
