// `palpate world sample`: what the devices of a simulated laboratory would have recorded, as files.
//
// The recordings are those of the acquisition procedures, run on the simulated devices; truth.json beside
// them has the keys of the matching calibration's result. Deterministic for a seed. Errors: wrong use for
// unknown kinds and counts, refused where the world's devices cannot show what is asked for.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpate/calibration/pose_candidates.h"
#include "palpate/calibration/session/procedures.h"
#include "palpate/core/expected.h"
#include "palpate/rig/rig.h"
#include "palpate/sim/simulator.h"

namespace palpate::evaluation {

enum class SampleKind { pivot, arm, hand_eye, camera, pointer, surface, landmarks };

struct SampleRequest {
  SampleKind kind = SampleKind::arm;
  std::uint64_t seed = 1;
  int points = 0;           // 0: the kind's usual number
  bool continuous = false;  // arm: the stylus moves while it is recorded
  bool guided = false;      // arm: the person is shown where the next pose helps most
};

// The devices of a simulated world, as procedures want them.
calibration::session::AcquisitionContext laboratory_of(sim::Simulator& world);

// What the makers of this world's arm and tracker state about where a stylus can be and be seen.
calibration::ReachablePoses reach_of(const sim::config::WorldFile& file);

// The rig before anything is calibrated: what makers state of arm and markers.
rig::Rig blank_rig(const sim::config::WorldFile& file);

// Camera pose from the board in an image of the simulated camera, found without drawing: true corners with
// the noise of finding them, solved with the true lens.
calibration::session::SeeBoard see_board_in(sim::Simulator& world);

// Writes the files of `request.kind` into `folder`, which is made where it is missing, and returns their paths,
// truth.json last. Those of an earlier sample are replaced; another table of that name is wrong use.
Expected<std::vector<std::filesystem::path>> sample_world(const sim::config::WorldFile& file,
                                                          const SampleRequest& request,
                                                          const std::filesystem::path& folder);

}  // namespace palpate::evaluation
