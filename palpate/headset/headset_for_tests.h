// For tests: a headset on the test runtime, loaded by OpenXR's own loader, and pictures with dots in them.
#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>

#include "palpate/core/log.h"
#include "palpate/headset/headset.h"
#include "test_runtime/test_runtime_for_tests.h"

namespace palpate::headset {

// The runtime that openxr_test.json names, before the loader loads it, and after.
inline TestRuntime& the_test_runtime() {
  static TestRuntime& runtime = []() -> TestRuntime& {
    void* const library = dlopen(PALPATE_TEST_RUNTIME, RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) throw std::runtime_error(dlerror());
    const auto get = reinterpret_cast<TestRuntime* (*)()>(dlsym(library, kTestRuntimeSymbol));
    if (get == nullptr) throw std::runtime_error("the test runtime does not export its control");
    return *get();
  }();
  return runtime;
}

// A busy machine, or a sanitizer, may take long over what ought to take milliseconds.
template <typename Condition>
bool comes_to_be(Condition condition) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

class HeadsetTest : public testing::Test {
 protected:
  HeadsetTest() {
    setenv("XR_RUNTIME_JSON", PALPATE_TEST_RUNTIME_JSON, 1);
    runtime.reset();
    settings.eyes = {Eye{}};
    settings.monotonic_ns = [this] { return runtime.now_ns(); };
    settings.closing = std::chrono::seconds(60);
    settings.opening = std::chrono::seconds(60);
  }
  ~HeadsetTest() override { close(); }

  void open() {
    auto opened = Headset::open(settings);
    if (!opened) throw std::runtime_error(opened.error().message);
    headset = std::move(*opened);
  }
  // Whatever the runtime was told to do, nobody is left waiting in it.
  void close() {
    runtime.run_by_itself();
    headset.reset();
  }

  Instant<GraphicsClock> now() const { return {Duration(runtime.now_ns())}; }
  void refresh(int times = 1) {
    for (int i = 0; i < times; ++i) ASSERT_TRUE(runtime.refresh()) << "no frame came";
  }

  TestRuntime& runtime = the_test_runtime();
  HeadsetSettings settings;
  std::unique_ptr<Headset> headset;
};

}  // namespace palpate::headset
