// The last seconds of one marker's tracked poses, asked for at an image's time.
//
// Times are the graphics host's, as the clock model of the tracker gives them. One thread. Asking outside
// what was seen, or across a gap in which the marker was hidden for longer than `longest_gap`, gives nothing:
// no guess.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>
#include <optional>

#include "palpate/math/pose.h"
#include "palpate/time/instant.h"

namespace palpate::device {

struct MarkerPose {
  Instant<GraphicsClock> time;
  Quaternion rotation = Quaternion::Identity();
  Vector3 translation = Vector3::Zero();
  Matrix6 covariance = Matrix6::Zero();  // rotation, then translation
};

class MarkerHistory {
 public:
  explicit MarkerHistory(Duration longest_gap = seconds(0.1), Duration kept = seconds(2.0))
      : longest_gap_(longest_gap), kept_(kept) {}

  // Poses older than the newest are ignored (a tracker's packets may arrive twice or late).
  void add(const MarkerPose& pose);
  std::optional<MarkerPose> at(Instant<GraphicsClock> time) const;
  // How it goes on after the newest pose: steadily, or changing its rates as it did before, which follows a head that turns about
  // and makes more of the tracker's noise.
  enum class Course { steady, accelerating };
  // At `time` after the newest pose: carried on with the turn and shift that fit the last `span` (least squares). Nothing where
  // fewer than three poses lie in it or the newest is older than `longest_gap`; steadily below kLeastAccelerating.
  static constexpr std::ptrdiff_t kLeastAccelerating = 5;
  std::optional<MarkerPose> predict(Instant<GraphicsClock> time, Course course = Course::steady,
                                    Duration span = seconds(0.06)) const;
  bool empty() const { return poses_.empty(); }

 private:
  Duration longest_gap_, kept_;
  std::deque<MarkerPose> poses_;
};

}  // namespace palpate::device
