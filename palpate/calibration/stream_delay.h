// The constant delay between two streams that saw the same point move: the arm's tip by its encoders, and by
// the tracker.
//
// Model: late(t) = early(t - d) + c + noise. d is the delay (s), c a constant offset (m) that soaks up what
// the calibrations of place have left, so that it cannot pass for time. Least squares on d and c with the
// early stream interpolated linearly (it is the fast one), residuals weighted by Huber's rule with the scale
// from the median. Pure functions. Refused: fewer than 20 points in the common time, a point that hardly
// moves, no convergence.
#pragma once

#include <vector>

#include "palpate/core/expected.h"
#include "palpate/math/estimate.h"
#include "palpate/math/so3.h"

namespace palpate::calibration {

struct TimedPoint {
  double time_s = 0.0;
  Vector3 place = Vector3::Zero();  // m
};

struct StreamDelay {
  double delay_s = 0.0;              // late stream's stamps minus the early stream's, for the same moment
  Vector3 offset = Vector3::Zero();  // c, m
  double rms_speed = 0.0;            // m/s, of the early stream: what the delay is seen by
};

struct StreamDelayOptions {
  double longest_s = 0.5;      // delays beyond +- this are not looked for
  double needed_speed = 0.02;  // m/s, rms
};

// Both streams in time order. Covariance order: delay (s), offset 3 (m).
Expected<Estimate<StreamDelay>> estimate_stream_delay(const std::vector<TimedPoint>& early,
                                                      const std::vector<TimedPoint>& late,
                                                      const StreamDelayOptions& options = {});

// What a smooth systematic error of one of the two streams passes for as delay, as a standard deviation in s: it comes
// back with the place, so that no residual shows it. `systematic`: its rms per axis, m, correlated by
// exp(-d^2 / (2 reach^2)) over the distance d (K below), the axes independently. With w the speeds about their mean, since a
// constant offset is eliminated (more that is eliminated leaves less):
//   sd^2 = sum over axes of w' K w / (sum over axes of w' w)^2
// On a way there and back it cancels; on one around something it does not. Of many points every n-th is taken.
inline constexpr double kSystematicReach = 0.15;  // m
double delay_of_systematic(const std::vector<TimedPoint>& points, double systematic,
                           double reach = kSystematicReach);

}  // namespace palpate::calibration
