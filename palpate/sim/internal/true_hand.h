// The person's hand at the stylus as the simulated camera sees it: five fingers, palm, wrist and forearm. Truth, and
// another shape than the one by which pictures know what a hand hides (palpate/render/hand_shape.h). Pure values.
#pragma once

#include <vector>

#include "palpate/render/arm_shape.h"
#include "palpate/sim/true_view.h"

namespace palpate::sim {

// In the stylus' frame, with `segments` round each bone; of no hand: none.
std::vector<render::ArmPart> true_hand_parts(const TrueHand& hand, int segments);

}  // namespace palpate::sim
