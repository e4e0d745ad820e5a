// For tests: an OpenXR runtime without a headset, loaded into the test's own process by OpenXR's loader.
//
// The head moves as it is told to. What is handed over is composited by plain C++ that shares no code with what is
// tested: for each pixel of an eye a ray is sent from where the eye is at that moment, and quad and projection layers
// answer it as the specification says. It needs neither display nor graphics card; pictures are read back from the
// application's own OpenGL context. Wrong use (calls out of order, unknown layers or formats) is answered with the
// specification's error.
//
// Time is CLOCK_MONOTONIC's, or a virtual one that refresh() moves on by the display's period. The runtime's own
// XrTime differs from either by kXrTimeAhead_ns. All functions may be called from any thread. In a process that nobody
// steers it runs by itself, and what stands in the file that PALPATE_TEST_RUNTIME_FILE names (hang, vanish, or nothing)
// becomes of it.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace palpate::headset {

inline constexpr std::int64_t kXrTimeAhead_ns = 500'000'000;

// Of the head (VIEW) in the room (LOCAL): metres, x right, y up, z backwards; a unit quaternion.
struct HeadPlace {
  double x = 0.0, y = 0.0, z = 0.0;
  double qw = 1.0, qx = 0.0, qy = 0.0, qz = 0.0;
};

// What an eye sees: packed RGB, row 0 on top.
struct EyePicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

struct TestDisplay {
  double rate_hz = 90.0;
  int pixels = 480;                         // of an eye, across and down
  double half_view = 42.5 * 0.01745329252;  // rad, to each of the four sides
  double eye_distance = 0.064;              // m
  double ahead_periods = 2.0;               // from a frame's begin until it is seen
};

struct TestCounts {
  std::uint64_t refreshes = 0;    // of the display, in virtual time
  std::uint64_t frames = 0;       // ended
  std::uint64_t with_layers = 0;  // of these, such as showed something
  std::uint64_t quads = 0;        // in the newest frame
  std::uint64_t uploads = 0;      // pictures released to it
  std::uint64_t instances = 0;    // made
  std::int64_t display_ns = 0;    // of the newest frame
  bool waiting = false;           // somebody is in xrWaitFrame
};

class TestRuntime {
 public:
  enum class Refusal : std::uint8_t {
    none,
    no_service,  // as a runtime whose service does not run
    no_headset,
    no_egl,
    no_times,
    no_srgb
  };

  virtual ~TestRuntime() = default;
  // As it is when it is loaded: nobody at it, the head at rest, virtual time at 1000 s. Only while no instance is open.
  virtual void reset(const TestDisplay& display = {}) = 0;

  virtual void move_head(std::function<HeadPlace(std::int64_t monotonic_ns)> place) = 0;
  // Someone says that where the head is looking is in front: LOCAL is laid there, upright or not, from now on.
  virtual void lay_local_anew() = 0;

  virtual std::int64_t now_ns() const = 0;
  virtual std::int64_t period_ns() const = 0;
  // Virtual time goes on by a period and a frame is asked for. True once that frame has been handed over, false where
  // that has not happened after `patience_s` of real time.
  virtual bool refresh(double patience_s = 20.0) = 0;
  // From now on frames are asked for by real time; nothing is left waiting.
  virtual void run_by_itself() = 0;

  virtual void wear(bool worn) = 0;  // nobody wears it: the session is stopped
  virtual void hang(bool hung) = 0;  // xrWaitFrame does not return
  virtual void end_session_by_force() = 0;
  virtual bool instance_open() const = 0;
  virtual void vanish() = 0;  // every call fails, and no instance can be made
  virtual void return_again() = 0;
  virtual void refuse(Refusal refusal) = 0;

  virtual EyePicture seen(int eye, std::int64_t monotonic_ns) const = 0;  // 0 left, 1 right
  virtual TestCounts counts() const = 0;
};

// What the shared object exports beside OpenXR's own entry point.
inline constexpr const char* kTestRuntimeSymbol = "palpate_test_runtime";

}  // namespace palpate::headset
