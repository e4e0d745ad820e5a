#include "palpate/desktop/force_bar.h"

#include <cmath>

namespace palpate::desktop {

void ForceBar::feel(double t, double newton) {
  if (!(newton > 0.0) || newton < level(t)) return;
  peak_ = newton;
  at_ = t;
}

double ForceBar::level(double t) const {
  const double since = t - at_;
  if (since <= kHold_s) return peak_;
  return peak_ * std::exp(-(since - kHold_s) / kFall_s);
}

}  // namespace palpate::desktop
