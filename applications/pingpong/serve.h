// Serves: balls thrown from near the wall so that they bounce once on the table and reach the player.
// Found by trial at construction (seeded); pure otherwise.
#pragma once

#include <vector>

#include "applications/pingpong/ball_world.h"
#include "palpate/core/random.h"

namespace palpate::applications::pingpong {

struct ServeSettings {
  // Where a serve is aimed, from the middle of the table's near edge: to the right, above the table, towards
  // the wall, m. A right-handed player's arm stands there.
  Vector3 aim{0.05, 0.30, 0.02};
  double aim_sd = 0.04;                          // m, sideways
  double height_low = 0.24, height_high = 0.42;  // above the table at the aim
  double shortest_s = 0.50, longest_s = 0.65;    // flight to the aim
};

// `count` different serves with speeds within game.serve_speed; where too few have the height and flight
// asked for, others follow that come a little higher, lower, sooner or later. Throws std::runtime_error where
// table and wall leave no possible serve (the message says what was tried).
std::vector<physics::BallState> make_serves(const scene::SceneDescription& scene, const GameSettings& game,
                                            const BallWorld& world, const ServeSettings& settings, int count,
                                            Random& random);

}  // namespace palpate::applications::pingpong
