#include "tests/fake_camera_clock.h"

#include <arv.h>
#include <dlfcn.h>
#include <time.h>

#include <utility>

namespace palpate {
namespace {

constexpr guint32 kControl = 0x944, kHigh = 0x948, kLow = 0x94c, kLatch = 2;

std::uint64_t wall_clock() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000u + static_cast<std::uint64_t>(now.tv_nsec);
}

std::function<std::uint64_t()>& clock_of_camera() {
  static std::function<std::uint64_t()> clock = wall_clock;
  return clock;
}

template <typename Function>
Function library(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

void set_fake_camera_clock(std::function<std::uint64_t()> clock) { clock_of_camera() = std::move(clock); }

}  // namespace palpate

extern "C" gboolean arv_fake_camera_write_register(ArvFakeCamera* camera, guint32 address, guint32 value) {
  static const auto write =
      palpate::library<decltype(&arv_fake_camera_write_register)>("arv_fake_camera_write_register");
  const auto& clock = palpate::clock_of_camera();
  if (address == palpate::kControl && value == palpate::kLatch && clock) {
    const std::uint64_t now = clock();
    write(camera, palpate::kHigh, static_cast<guint32>(now >> 32));
    write(camera, palpate::kLow, static_cast<guint32>(now));
  }
  return write(camera, address, value);
}
