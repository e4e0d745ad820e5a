// For tests: the stand-in for libHD.so, loaded as the driver loads it, and its simulated devices.
#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <chrono>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <thread>

#include "drivers/openhaptics/arm.h"
#include "stub/hd_stub.h"
#include "tests/comes_true.h"

namespace palpate::drivers::openhaptics {

inline const char* const kStub = HD_STUB_DIR "/whole/libHD.so";

using tests::comes_true;

// Whether the line has all of these words, and is one line.
inline bool says(const std::string& line, std::initializer_list<const char*> words) {
  for (const char* word : words)
    if (line.find(word) == std::string::npos) {
      ADD_FAILURE() << "'" << word << "' is not in: " << line;
      return false;
    }
  return line.find('\n') == std::string::npos;
}

class StubTest : public testing::Test {
 protected:
  StubTest() {
    library_ = dlopen(kStub, RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) throw std::runtime_error(dlerror());
    function<void()>("hd_stub_reset")();
  }

  template <typename Function>
  std::add_pointer_t<Function> function(const char* name) const {
    return reinterpret_cast<std::add_pointer_t<Function>>(dlsym(library_, name));
  }
  HdStubDevice& device(int number = 0) const {
    return *function<HdStubDevice*(int)>("hd_stub_device")(number);
  }
  void freeze(bool frozen) const { function<void(bool)>("hd_stub_freeze")(frozen); }
  bool scheduler_runs() const { return function<int()>("hd_stub_schedulers")() != 0; }

  // Reads or changes a device between its cycles.
  template <typename Work>
  auto with(Work work, int number = 0) const {
    const std::lock_guard lock(device(number).guard);
    return work(device(number));
  }
  Vector3 force(int number = 0) const {
    return with([](HdStubDevice& d) { return Vector3(d.force); }, number);
  }

  // Patient, so that a busy machine's hiccup does not count as the device's; without waits of its own.
  static ArmSettings patient() {
    ArmSettings settings;
    settings.library = kStub;
    settings.loop.watchdog_s = 10.0;
    settings.loop.ramp_s = 0.01;
    settings.hold_s = 0.05;
    return settings;
  }
  static std::unique_ptr<OpenHapticsArm> opened(const ArmSettings& settings) {
    auto arm = OpenHapticsArm::open(settings);
    if (!arm) throw std::runtime_error(arm.error().message);
    return std::move(*arm);
  }
  static bool reads(OpenHapticsArm& arm) { return arm.read().joints.allFinite(); }

 private:
  void* library_ = nullptr;
};

}  // namespace palpate::drivers::openhaptics
