// What a screen showed of the timecode, and when; and the moment that an image of it was taken.
//
// A screen changes when somebody draws on it: at its own rate, and not at all while a picture is being worked
// on. So the timecode in an image is not simply the time: it is what was on the screen then, held until the
// next change, averaged over the exposure. The log knows every change; the moment is the one at which the
// mean of what it holds is what was seen (least squares; between two changes entering or leaving the exposure
// the blocks are linear in time, so the best moment of each stretch has a closed form). Where nothing changed
// within the exposure a whole span of moments looks the same: the answer is its middle, and says how unsure
// it is. Host time of the graphics server. One thread. Errors: refused with the reason.
#pragma once

#include <deque>

#include "palpate/device/timecode.h"

namespace palpate::evaluation {

struct TimecodeMoment {
  Instant<GraphicsClock> middle;  // of the exposure, less the time from drawing to light
  Duration unsure{0};             // half of the span of moments that look the same
  double residual = 0.0;          // rms of the bits, as a share of the contrast
};

class TimecodeLog {
 public:
  // The timecode of time `code` was handed to the screen at `at`. Times that go back are ignored.
  void show(Instant<GraphicsClock> at, Duration code);
  bool empty() const { return shown_.empty(); }

  // When the screen, seen through `exposure`, looked like this; among the last two seconds, the exposure's
  // end not after `latest`.
  Expected<TimecodeMoment> find(const device::TimecodeBits& seen, Duration exposure,
                                Instant<GraphicsClock> latest) const;

 private:
  struct Shown {
    Instant<GraphicsClock> at;
    device::TimecodeBits bits{};
    device::TimecodeBits lit{};  // s that each bit was lit since the first entry ever, at `at`
  };
  struct Cursor;
  std::deque<Shown> shown_;
};

}  // namespace palpate::evaluation
