// By how much the clocks of two recordings of one motion differ, whatever each of them saw of it: poses of a
// body, places of a point, or one number that follows the motion (a line's position in a video, a potentiometer).
//
// Model: response(t) = B features(t + shift) + c + noise. The stream with more channels gives the features
// (poses: the entries of the rotation matrix and the place; points: the place; a signal: itself), the other one
// the response. B and c are free, so that neither the frames' places and turns nor units, scale, sign, mirrored
// axes or another point of the same body matter: a fixed point of a body is linear in the entries of its pose,
// and so is the pose of whatever else is mounted on it. Steps: rates of change on a common grid, correlated at
// every lag with overlap (internal/lag_search.h); then least squares on the shift with B and c eliminated
// (internal/shift_fit.h), multivariate t noise, standard deviation for residuals that are correlated in time.
//
// Channels: m for places, rotation entries times a lever of 0.2 m; seconds on the streams' own clocks, which may
// have any origins. Pure functions, no thread rule. Refused: too few samples, a stream that does not change, no
// delay that fits better than chance would, several that fit about equally well.
// Sources: Golub, Pereyra (1973) for the elimination; Lange, Little, Taylor (1989) for the noise.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "palpate/calibration/stream_delay.h"
#include "palpate/core/expected.h"
#include "palpate/device/pose_file.h"

namespace palpate::calibration {

struct Motion {
  std::string name;            // for messages
  std::vector<double> time_s;  // rising, no two equal
  Eigen::MatrixXd channels;    // a row for each time
};

// Rows may come in any order; of equal times the first is kept.
Motion motion_of_poses(std::string name, const std::vector<device::StampedPose>& poses);
Motion motion_of_points(std::string name, const std::vector<TimedPoint>& points);
Motion motion_of_signal(std::string name, const std::vector<double>& time_s,
                        const std::vector<double>& values);

struct MotionDelayOptions {
  double longest_s = std::numeric_limits<double>::infinity();  // delays beyond +- this are not looked for
};

struct MotionDelay {
  double delay_s = 0.0;  // to time = from time + delay
  double delay_std_s = 0.0;
  double correlation = 0.0;     // multiple correlation of response and features at this delay, 0 ... 1
  double overlap_s = 0.0;       // common time at this delay
  int samples = 0;              // of the slower stream, compared; of very many every n-th
  double noise_memory_s = 0.0;  // how long residuals stay alike; 0 where they look white
  double std_grown_by = 1.0;    // factor on the deviation because of that
  struct Other {
    double delay_s = 0.0, correlation = 0.0;
  };
  std::vector<Other> others;  // next best delays, best first
  std::vector<std::string> warnings;
};

Expected<MotionDelay> estimate_motion_delay(const Motion& from, const Motion& to,
                                            const MotionDelayOptions& options = {});

}  // namespace palpate::calibration
