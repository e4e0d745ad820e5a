// The paper's Figures 4 and 5: a marker swung about a tip, and how far off centre and tip are found.
//
// A run draws poses on a full sphere (any orientation) or a quarter of one (a cap of a quarter of its area,
// rolled by up to 60 degrees), shifts the tip as told, and gives each LED an error: white noise and a smooth
// bias field in the proportion of the world file, alike in all directions. The bias is read where the LED is
// while the tip rests: 3 mm of motion are a fiftieth of the field's correlation length. Marker frame and
// World, SI. Internal to this module; deterministic for a seed.
#pragma once

#include <vector>

#include "palpate/calibration/pivot.h"
#include "palpate/core/random.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::evaluation::studies {

enum class Coverage { full_sphere, quarter_sphere };
enum class TipMotion {
  random,  // the paper's: normal, alike in all directions
  dragged  // a hand's pull: along the stylus, so that it turns with the marker
};

// Share of the squared LED error that is bias, as in the world file.
double bias_share_of(const sim::config::WorldFile& world);

struct SwingSettings {
  Coverage coverage = Coverage::full_sphere;
  TipMotion motion = TipMotion::random;
  double bias_share = 0.0;  // of the squared LED error: the smooth field's part
  int poses = 100;
};

struct SwingErrors {
  double led_rms = 0.0;  // m, 3-D, of one LED
  double tip_rms = 0.0;  // m, 3-D, of the tip's displacement
};

struct Swing {
  std::vector<calibration::PivotPose>
      poses;  // with the arm's own account of the displacement, right to 1 % and 0.03 mm
  Vector3 mean_place = Vector3::Zero();  // m, of the tip; the place it is held at is the origin of World
};

// One draw of poses and chance, of which swings with larger and smaller errors are made.
class SwingDraw {
 public:
  SwingDraw(const sim::config::WorldFile& world, const SwingSettings& settings, std::uint64_t seed);
  Swing with(const SwingErrors& errors) const;

 private:
  struct Look {
    Quaternion rotation;
    Vector3 shift;              // of the tip, for 1 m rms
    std::vector<Vector3> leds;  // error of each for 1 m rms; the bias as at the still tip
    Vector3 arm_noise;          // m
  };
  const std::vector<Vector3>& model_;
  Vector3 tip_;
  Quaternion R_world_arm_;
  std::vector<Look> looks_;
};

}  // namespace palpate::evaluation::studies
