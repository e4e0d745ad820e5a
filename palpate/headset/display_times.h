// When a picture that is handed over at some moment will be seen: the runtime's promise for its newest frame, carried
// on by whole periods.
//
// A frame takes the newest picture when it begins and is seen at the runtime's predictedDisplayTime; the next one begins,
// and is seen, a period later. By the specification that time is the middle of the display's interval. Value; the
// graphics host's clock.
#pragma once

#include "palpate/time/instant.h"

namespace palpate::headset {

struct DisplayTimes {
  Instant<GraphicsClock> begun;      // when the newest frame began
  Instant<GraphicsClock> displayed;  // when the runtime expects that frame to be seen
  Duration period{0};                // 0: no frame yet

  bool known() const { return period > Duration(0); }
  // Of a picture handed over then; the moment itself where nothing is known.
  Instant<GraphicsClock> of_picture(Instant<GraphicsClock> handed_over) const {
    if (!known()) return handed_over;
    const Duration after = handed_over - begun;
    const auto frames = after <= Duration(0) ? 0 : (after + period - Duration(1)) / period;
    return displayed + frames * period;
  }
};

}  // namespace palpate::headset
