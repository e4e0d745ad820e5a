// The paper's Figures 4 and 5: a marker swung about a tip, and how far off centre and tip are found.
//
// A run draws poses on a full sphere (any orientation) or a quarter of one (a cap of a quarter of its area,
// rolled by up to 60 degrees), shifts the tip as told, and gives each LED an error: white noise and a smooth
// bias field in the proportion of the world file, alike in all directions. Marker frame and World, SI.
// Internal to this module; deterministic for a seed.
#pragma once

#include <vector>

#include "palpate/calibration/pivot.h"
#include "palpate/core/random.h"
#include "palpate/sim/world_file.h"

namespace palpate {

enum class Coverage { full_sphere, quarter_sphere };
enum class TipMotion {
  random,  // the paper's: normal, alike in all directions
  dragged  // a hand's pull: along the stylus, so that it turns with the marker
};

struct SwingSettings {
  Coverage coverage = Coverage::full_sphere;
  TipMotion motion = TipMotion::random;
  double led_rms = 0.0;   // m, 3-D, of one LED
  double bias_share = 0;  // of led_rms^2: the smooth field's part
  double tip_rms = 0.0;   // m, 3-D, of the tip's displacement
  int poses = 100;
};

// Share of the squared LED error that is bias, as in the world file.
double bias_share_of(const sim::WorldFile& world);

struct Swing {
  std::vector<PivotPose> poses;  // with the arm's own account of the displacement, right to 1 % and 0.03 mm
  Vector3 mean_place = Vector3::Zero();  // m, of the tip; the place it is held at is the origin of World
};

Swing swing(const sim::WorldFile& world, const SwingSettings& settings, std::uint64_t seed);

}  // namespace palpate
