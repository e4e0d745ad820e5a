// One camera as its interface shows it: opens, gives frames one after the other, and says what is wrong.
//
// Written for each interface (aravis_source.h, v4l2_source.h, recorded_source.h); live_camera.h makes a
// CameraDevice of it. Used by one thread at a time; may wait, but never longer than it is told (opening and
// closing aside). Stamps: the camera's own clock, already brought to mid-exposure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/cameras/mid_exposure.h"
#include "drivers/cameras/pixel_format.h"
#include "palpate/core/expected.h"

namespace palpate::drivers::cameras {

using device::CameraSettings;

struct CameraFacts {
  std::string model, serial;  // may be empty
  int width = 0, height = 0;  // px
  PixelFormat format = PixelFormat::rgb8;
  double rate_hz = 0.0;     // 0: not told
  double exposure_s = 0.0;  // 0: not told
  std::string stamp;        // what its stamps mark, in words
};

struct Frame {
  std::int64_t mid_exposure_ns = 0;
  std::uint64_t number = 0;  // counts frames taken: a gap is a lost frame
  // When it reached this machine, on its monotonic clock, as far as the interface tells; 0: as it is handed over.
  std::int64_t arrived_ns = 0;
  // The host's time of mid-exposure on the same clock, where the interface can tell it without what the picture
  // took to come; 0: it cannot.
  std::int64_t taken_ns = 0;
  RawPicture picture;  // valid until the source is used again
};

struct Outcome {
  enum class Kind : std::uint8_t {
    frame,
    nothing,  // none came in time
    damaged,  // one came that cannot be used; the camera goes on. `words` say why
    lost,     // the camera is gone: close, and open again. `words` say why and what to do
    ended,    // a recording has no more
  };
  Kind kind = Kind::nothing;
  Frame frame;
  std::string words;
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // "v4l2:/dev/video0" as a person would name it.
  virtual const std::string& name() const = 0;
  // Refused or wrong use in words for a person, the camera being closed then.
  Expected<CameraFacts> open() {
    auto facts = try_open();
    if (!facts) close();
    return facts;
  }
  // The newest frame; older ones that nobody took are passed over. Waits at most so long. Recordings leave
  // none out, since nobody would get it again.
  virtual Outcome wait(Duration longest) = 0;
  virtual void close() = 0;
  // It is silent on purpose, as a recording between two pictures: opening it anew would be no help.
  virtual bool keeps_its_own_pace() const { return false; }

 private:
  // What it has opened when it is refused is closed.
  virtual Expected<CameraFacts> try_open() = 0;
};

}  // namespace palpate::drivers::cameras
