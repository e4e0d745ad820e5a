// `palpate study palpation`: what the scripted trainee can tell by feel, and what delays, sight and practice do to it.
//
// On a flat block (block_forces.h): detection of a nodule over its depth, size and stiffness, with and without sight; over
// its depth with force, picture or both late, in linear instead of neo-Hookean matter, after sessions of practice, with the
// sense of force off; by constant stimuli and by staircase; how stiff something late feels; searches of a grid beside the
// reference table. Bars say whether what must come out does. Deterministic by seed.
#pragma once

#include "palpate/scene/application_study.h"

namespace palpate::applications::palpation {

scene::ApplicationStudy palpation_study();

}  // namespace palpate::applications::palpation
