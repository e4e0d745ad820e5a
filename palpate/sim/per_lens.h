// What is made for a lens and takes as long as some pictures to make: kept for the last two, as two cameras take turns.
// One thread.
#pragma once

#include <array>
#include <memory>

#include "palpate/device/camera_model.h"

namespace palpate::sim {

template <class Parts>
class PerLens {
 public:
  // `make(lens)`: Parts, where there are none for this lens yet.
  template <class Make>
  Parts& of(const device::CameraModel& lens, const Make& make) {
    for (std::size_t i = 0; i < kept_.size(); ++i)
      if (kept_[i] && kept_[i]->lens == lens) {
        latest_ = i;
        return kept_[i]->parts;
      }
    if (kept_[latest_]) latest_ = 1 - latest_;
    kept_[latest_].reset(new Kept{lens, make(lens)});
    return kept_[latest_]->parts;
  }
  // Those asked for last; some have to be.
  Parts& latest() { return kept_[latest_]->parts; }

 private:
  struct Kept {
    device::CameraModel lens;
    Parts parts;
  };
  std::array<std::unique_ptr<Kept>, 2> kept_;  // parts may be such that cannot be moved
  std::size_t latest_ = 0;
};

}  // namespace palpate::sim
