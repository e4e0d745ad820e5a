// When the picture for those who look on may be drawn: in the time that the player's pictures leave.
//
// Player's pictures come at a steady beat; between two of them there is time to spare, or there is not. A
// picture for onlookers is drawn at most 25 times a second, and where it is expected to be done before the
// player's next image; where there never is such a time it is drawn all the same, but then takes a sixth of
// the loop's time at most and comes five times a second at most. Pure, deterministic; one thread.
#pragma once

#include <optional>

#include "palpate/time/instant.h"

namespace palpate::desktop {

class SpectatorPace {
 public:
  static constexpr Duration kShortest = std::chrono::milliseconds(40);  // from one to the next
  static constexpr Duration kOverdue = std::chrono::milliseconds(200);
  static constexpr int kShare = 6;

  // Asked once for each of the player's pictures, after it has been shown: `begun`, its image taken up.
  bool due(Instant<GraphicsClock> begun, Instant<GraphicsClock> now);
  // One was drawn just now; it took so long.
  void drew(Instant<GraphicsClock> begun, Duration took);

 private:
  std::optional<Instant<GraphicsClock>> before_, last_;
  Duration beat_{0};  // of the player's pictures, smoothed; 0: not known yet
  Duration cost_{0};  // of a picture for onlookers: a longer one counts at once, a shorter one half
};

}  // namespace palpate::desktop
