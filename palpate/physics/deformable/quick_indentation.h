// The same block pressed by the law of the haptic loop: a site's closed form instead of a finite-element solution.
//
// Two or one linear solutions of the block give the residual compliance of the middle of its top. SI; errors as
// indentation.h. Some seconds, one thread; it allocates.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "palpate/physics/deformable/indentation.h"
#include "palpate/physics/deformable/site_law.h"

namespace palpate::physics::deformable {

Expected<SiteLaw> site_law_of_block(const Indentation& indentation);
// Of the same block with one set of inclusions after the other in place of its own: one mesh, that of the block without any
// symmetry that a set lacks, and one solution without inclusions. `done` hears how many sets are; may be empty.
Expected<std::vector<SiteLaw>> site_laws_of_block(const Indentation& indentation,
                                                  std::span<const std::vector<Inclusion>> sets,
                                                  const std::function<void(std::size_t)>& done = {});
// Neo-Hookean matter alone; wrong use for another model. Friction changes nothing here: the law's acts along the surface
// alone, and in the middle of the top nothing slips.
Expected<std::vector<IndentationPoint>> quick_indentation(const Indentation& indentation);

}  // namespace palpate::physics::deformable
