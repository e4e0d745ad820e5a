// What is kept of a search: a line per millisecond of contact, marks and nodules once it is over, its figures, and which
// pictures show where is pressed. One thread.
#pragma once

#include <vector>

#include "applications/palpation/scene_view.h"
#include "palpate/scene/application_registry.h"

namespace palpate::applications::palpation {

// time_s,force_n,depth_mm,speed_mm_s,tip_x_mm,tip_y_mm,tip_z_mm; the tip in the organ's frame.
inline constexpr const char* kPressTable = "palpation.csv";
// kind,x_mm,y_mm,z_mm,radius_mm,right: nodules (0, at the surface above them) and marks (1), in the organ's frame;
// right: found, or has found one.
inline constexpr const char* kMarkTable = "palpation_marks.csv";

class PalpationRecord : public scene::PlayRecord {
 public:
  explicit PalpationRecord(const scene::SceneDescription& scene);

  void add_state(const scene::SceneState& state) override;

  // In sight: the tip is inside the picture.
  scene::Highlight highlight(const scene::ShownPicture& picture) const override;
  std::vector<std::string> tables() const override;
  // "palpation": by staircase level, over, trial, nodules, found, missed, marks, false_alarms, position_error_mm_median, seconds, path_m, presses,
  // force_p95_n, force_max_n, hard_presses, depth_mm_max, energy_created_j. Of the search that was over last, else of
  // the one that was going on, whose nodules nobody has been told: null.
  Json summary() const override;
  std::vector<scene::ClosingLine> closing_lines(const Json& summary) const override;

 private:
  struct Row {
    double time, force, depth, speed;  // s, N, m, m/s
    Vector3 tip;
  };
  const scene::SceneState& judged() const { return over_ ? shown_ : last_; }

  PalpationSettings settings_;
  mutable RevealedNodules revealed_;
  std::vector<Row> rows_;
  bool over_ = false;
  std::int32_t created_nj_ = 0;  // the most of any trial
  scene::SceneState shown_, last_;
};

// Record, tables and report of palpation.
void add_record(scene::ApplicationSpec& spec);

}  // namespace palpate::applications::palpation
