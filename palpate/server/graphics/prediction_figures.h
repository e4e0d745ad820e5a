// What predicted pictures' errors (prediction_check.h) come to: figures for the end of a run, and the raw file
// realtime_predictions.csv.
//
// Columns, a row for each picture: frame, ahead_ms (by so much the state was carried on), moment_ms (its light left so much
// after the moment it was made for), then of the tip and of each body that has a name its distance, mm, from where it was
// when the light left: NAME_mm as shown, NAME_newest_mm as the newest state that was known had it, NAME_registered_mm as
// it was when the image was taken (empty where an impact came between); head_mm, head_deg of the head's marker; shape_mm of the
// worst vertex of a surface that deforms (every fourth picture). One thread.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "palpate/core/csv_file.h"
#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/core/statistics.h"
#include "palpate/scene/application.h"
#include "palpate/server/graphics/prediction_check.h"

namespace palpate::server::graphics {

class PredictionLog {
 public:
  // In this folder.
  static Expected<PredictionLog> begin(const std::filesystem::path& folder,
                                       const scene::SceneDescription& scene);
  void add(const PredictionError& error);
  Expected<void> finish() { return rows_.finish(); }

 private:
  PredictionLog(CsvFile rows, std::vector<std::size_t> bodies)
      : rows_(std::move(rows)), bodies_(std::move(bodies)) {}
  CsvFile rows_;
  std::vector<std::size_t> bodies_;
};

// Of the first kKept pictures of a run, ten minutes and more: memory stays bounded.
class PredictionFigures {
 public:
  static constexpr std::uint64_t kKept = 20'000;

  void add(const PredictionError& error);
  std::uint64_t pictures() const { return pictures_; }
  // {pictures, ahead_ms_median, moment_ms {median, p95 of its size}, tip {...}, bodies by name, head {mm_rms, deg_rms}, shape}; of a
  // place {shown, newest, registered}, each {rms_mm, median_mm, p95_mm}.
  Json json(const scene::SceneDescription& scene) const;

 private:
  struct Places {
    ErrorSummary shown, newest, registered;
    void add(const PlaceErrors& errors);
    Json json() const;
  };
  std::uint64_t pictures_ = 0;
  ErrorSummary ahead_, moment_, moment_size_, head_m_, head_rad_, shape_;
  Places tip_;
  std::array<Places, scene::SceneState::kBodies> bodies_;
};

}  // namespace palpate::server::graphics
