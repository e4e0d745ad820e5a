// The hand that holds the stylus, as coarsely as a picture needs it to know what a hand hides: fingers round the
// handle, palm and forearm as capsules.
//
// It stands in the frame of the stylus (arm_shape.h, ArmFrame::stylus: origin at the tip, +z along the handle), so that
// it follows tip and gimbal; where the elbow is nobody measures. Sizes are those of a grown person's hand that holds the
// stylus like a pen (widths and lengths of the hand: Garrett 1971, the medians); another hand lies up to a centimetre
// beside. Pure values.
#pragma once

#include <vector>

#include "palpate/device/holding_hand.h"
#include "palpate/render/arm_shape.h"

namespace palpate::render {

// A capsule from `a` to `b`, in the stylus' frame, m.
struct HandCapsule {
  Vector3 a, b;
  double radius_a = 0.0, radius_b = 0.0;
};
// Closed; an end is a ball.
scene::TriangleMesh capsule_mesh(const HandCapsule& capsule, int segments = 20);

// Of no hand: none.
std::vector<ArmPart> coarse_hand_parts(device::HoldingHand hand);

}  // namespace palpate::render
