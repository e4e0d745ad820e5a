// What happened while touch was played: a line per millisecond with the surface touched, and its figures.
// One thread.
#pragma once

#include <filesystem>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/scene/scene_state.h"

namespace palpate::tools::demo {

class TouchLog {
 public:
  void add(const scene::SceneState& state);

  // The summary's "touch": contact_s, of_s, touches, slips, sliding_share; force_n and depth_mm (of the tip
  // below the surface) {mean, p95, max}; friction {median}, of tangential over normal force while it slides;
  // unsettled.
  Json summary() const;
  // touch.csv in that folder:
  // time_s,force_n,tangential_n,depth_mm,speed_mm_s,sliding,tip_x_m,...,normal_x,...
  Expected<void> write(const std::filesystem::path& folder) const;

 private:
  struct Row {
    double time, force, tangential, depth, speed;  // s, N, N, m, m/s
    bool sliding;
    Vector3 tip, normal;
  };
  std::vector<Row> rows_;
  std::size_t all_ = 0;  // states seen
  double first_ = 0.0, last_ = 0.0;
  std::int32_t touches_ = 0, slips_ = 0, unsettled_ = 0;
};

}  // namespace palpate::tools::demo
