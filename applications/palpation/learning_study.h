// `palpate study learning --file FILE`: what a person has learned, from the searches that palpation has kept
// (learning_file.h). Figures of each session and a page with the curves; nothing is simulated.
#pragma once

#include "palpate/scene/application_study.h"

namespace palpate::applications::palpation {

scene::ApplicationStudy learning_study();

}  // namespace palpate::applications::palpation
