// A head-mounted display, over OpenXR: pictures of cameras on the head stand in space where they were taken, however
// old they are when they are seen.
//
// Each picture is a flat rectangle (a quad layer) at the distance of what one works at, placed in the runtime's LOCAL
// space by the head's pose at the middle of the camera's exposure. The runtime shows it from where the eye is by then:
// turns of the head are corrected for everything, shifts for what lies at that distance. A thread of its own hands the
// same picture to the runtime again at the display's rate, whatever cameras and drawing do. A second rectangle is
// fixed to the head, for words. Theory and limits: docs/theory/headset.md.
//
// Frames: palpate/headset/frames.h. Times are the graphics host's. Thread: open(), show(), show_panel(), trouble() and
// the destructor belong to one thread, the frame loop's; the others may be called from any. None waits for the runtime,
// except open() for the first answer and the destructor for the end, a second at most.
// Source: OpenXR specification 1.0, with XR_MNDX_egl_enable and XR_KHR_convert_timespec_time.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/headset/display_times.h"
#include "palpate/headset/head_history.h"
#include "palpate/headset/picture_quad.h"
#include "palpate/time/clock.h"
#include "palpate/time/standstill.h"

namespace palpate::headset {

// One camera and where it sits on the head.
struct Eye {
  device::CameraModel camera;  // of the undistorted picture; distortion is not looked at
  Pose<View, CameraOptical> X_view_camera = camera_between_the_eyes();
};

struct HeadsetSettings {
  std::vector<Eye> eyes;  // one, before both eyes; or the left one's and the right one's
  // The runtime's poses are late by this against the images: a picture of time t is placed by the pose of t + delay.
  Duration pose_delay{0};
  // Graphics host's time from the machine's monotonic one, which the runtime knows.
  MonotonicClock<GraphicsClock> clock;
  // What that clock reads; a test whose runtime has a clock of its own reads that.
  std::function<std::int64_t()> monotonic_ns = MonotonicClock<GraphicsClock>::monotonic_ns;
  Duration retry = std::chrono::seconds(2);           // between attempts to reach a runtime that has gone
  Duration opening = std::chrono::seconds(10);        // how long the first answer may take
  Duration silence = std::chrono::milliseconds(300);  // of the runtime, until trouble() says so
  Duration closing = std::chrono::seconds(1);         // how long the destructor waits for the runtime
};

struct Picture {
  // Packed, row 0 on top, encoded as sRGB; of two eyes side by side, the left one's first.
  std::span<const std::uint8_t> rgb;
  int width = 0, height = 0;          // of the whole
  Instant<GraphicsClock> image_time;  // mid-exposure
  double distance = 0.6;              // m, along the camera's axis: of what has to stand still
};

// Words before both eyes, fixed to the head.
struct WordPanel {
  // Red, green, blue and cover, row 0 on top, the colours multiplied by the cover; empty: nothing is shown.
  std::span<const std::uint8_t> rgba;
  int width = 0, height = 0;
  double wide = 0.5;                 // m; its height follows
  Vector3 middle{0.0, -0.25, -1.0};  // m, in View
};

enum class HeadsetState : std::uint8_t {
  absent,   // no runtime, or no headset at it; tried again and again
  waiting,  // the runtime does not want pictures now: nobody wears the headset, or something else is shown
  showing   // it asks for frames
};

struct HeadsetFacts {
  HeadsetState state = HeadsetState::absent;
  std::string runtime, device;       // as they name themselves
  std::string absence;               // why it is absent; one line
  std::uint64_t frames = 0;          // handed to the runtime
  std::uint64_t with_picture = 0;    // of these, such as had a picture to show
  std::uint64_t pictures = 0;        // handed over
  std::uint64_t pictures_shown = 0;  // of these, such as a frame took up; the others were replaced before
  std::uint64_t unplaced = 0;        // shown fixed to the head, for where it was at the image is not known
  std::uint64_t losses = 0;          // of a runtime that had been there
  DisplayTimes display;              // of the newest frame
};

class Headset {
 public:
  // Refused, with the remedy, where this program was built without OpenXR, and where no runtime, no headset, no EGL
  // binding or no conversion of times is to be had. Throws std::invalid_argument for other than one or two eyes.
  static Expected<std::unique_ptr<Headset>> open(const HeadsetSettings& settings);
  // Which runtime and headset there are, without showing anything; refused as open() is.
  static Expected<HeadsetFacts> look_for(Duration patience = std::chrono::seconds(10));
  // Whether the program was built with OpenXR.
  static bool built_in();

  // Leaves the thread behind where the runtime does not return; it holds what it uses.
  ~Headset();
  Headset(const Headset&) = delete;
  Headset& operator=(const Headset&) = delete;

  // Copies the picture and returns; the next frame of the headset takes it up. Throws std::invalid_argument where its
  // size is not that of the eyes' cameras, side by side.
  void show(const Picture& picture);
  void show_panel(const WordPanel& panel);

  // Why nothing new is to be seen in the headset, as of `now`; none: all is well, or nobody wants to see it. To be
  // asked ten times a second or more often.
  std::optional<std::string> trouble(Instant<GraphicsClock> now);

  HeadsetFacts facts() const;
  // Where the head was, or will be within a tenth of a second, by the runtime: pose_delay is not taken off.
  HeadHistory::Head head_at(Instant<GraphicsClock> time) const;
  // When a picture that is handed over then is expected to be seen.
  Instant<GraphicsClock> display_time(Instant<GraphicsClock> handed_over) const;
  // Of the picture that was taken up last: its image's time, and when it is seen for the first time.
  struct Shown {
    std::uint64_t picture = 0;  // in the order of show(), from 1
    Instant<GraphicsClock> image_time, displayed;
  };
  std::optional<Shown> shown() const;

 private:
  struct Impl;
  explicit Headset(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::headset
