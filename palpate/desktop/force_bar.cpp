#include "palpate/desktop/force_bar.h"

#include <algorithm>
#include <cmath>

namespace palpate::desktop {

void ForceBar::feel(double t, double newton) {
  if (!(newton > 0.0) || newton < level(t)) return;
  peak_ = newton;
  at_ = t;
}

double ForceBar::level(double t) const {
  const double since = t - at_;
  const double fallen = since <= kHold_s ? peak_ : peak_ * std::exp(-(since - kHold_s) / kFall_s);
  return std::max(fallen, lasting_);
}

}  // namespace palpate::desktop
