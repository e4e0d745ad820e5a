// What is kept of a surface's exploration: a line per millisecond with the surface touched, its figures, and which
// pictures show the place that is touched. One thread.
#pragma once

#include <vector>

#include "palpate/scene/application_registry.h"

namespace palpate::applications::touch {

// time_s,force_n,tangential_n,depth_mm,speed_mm_s,sliding,tip_x_m,...,normal_x,...
inline constexpr const char* kTouchTable = "touch.csv";

class TouchRecord : public scene::PlayRecord {
 public:
  void add_state(const scene::SceneState& state) override;

  // In sight: the proxy, where the surface is touched, is inside the picture.
  scene::Highlight highlight(const scene::ShownPicture& picture) const override;
  std::vector<std::string> tables() const override;
  // "touch": contact_s, of_s, touches, slips, sliding_share; force_n and depth_mm (of the tip below the surface)
  // {mean, p95, max}; friction {median}, of tangential over normal force while it slides; unsettled.
  Json summary() const override;
  std::vector<scene::ClosingLine> closing_lines(const Json& summary) const override;

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

// Record, table and report of an exploration.
void add_record(scene::ApplicationSpec& spec);

}  // namespace palpate::applications::touch
