#include "palpate/server/graphics/prediction_figures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/csv.h"
#include "tests/scratch_folder.h"

namespace palpate::server::graphics {
namespace {

scene::SceneDescription game() {
  scene::SceneDescription scene;
  scene.bodies = {{"Ball", 0.0027}, {"", 0.0}, {"Bat 2", 0.1}};
  return scene;
}

// Of a picture: the tip 1 mm off, the ball 2 mm, the last body struck meanwhile.
PredictionError error_of(std::uint64_t frame, double scale = 1.0) {
  PredictionError error;
  error.frame = frame;
  error.ahead_s = 0.016;
  error.moment_s = -0.002 * scale;
  error.tip = PlaceErrors{0.001 * scale, 0.010 * scale, 0.030 * scale};
  error.bodies = {PlaceErrors{0.002 * scale, 0.020 * scale, 0.060 * scale}, PlaceErrors{}, std::nullopt};
  error.head_m = 0.004;
  error.head_rad = 0.01;
  if (frame % 2 == 0) error.shape_m = 0.003;
  return error;
}

TEST(PredictionFigures, AreOfWhatHasAName) {
  PredictionFigures figures;
  for (std::uint64_t i = 1; i <= 4; ++i) figures.add(error_of(i, i == 4 ? 2.0 : 1.0));
  const Json json = figures.json(game());
  EXPECT_EQ(json["pictures"], 4);
  EXPECT_DOUBLE_EQ(json["ahead_ms_median"], 16.0);
  EXPECT_DOUBLE_EQ(json["moment_ms"]["median"], -2.0);
  EXPECT_DOUBLE_EQ(json["moment_ms"]["p95"], 4.0) << "of its size";
  EXPECT_DOUBLE_EQ(json["tip"]["shown"]["median_mm"], 1.0);
  EXPECT_DOUBLE_EQ(json["tip"]["shown"]["p95_mm"], 2.0);
  EXPECT_NEAR(json["tip"]["shown"]["rms_mm"], std::sqrt((3.0 + 4.0) / 4.0), 1e-12);
  EXPECT_DOUBLE_EQ(json["tip"]["newest"]["median_mm"], 10.0);
  EXPECT_DOUBLE_EQ(json["tip"]["registered"]["median_mm"], 30.0);
  EXPECT_EQ(json["bodies"].size(), 1u) << "the second has no name, of the third nothing is known";
  EXPECT_DOUBLE_EQ(json["bodies"]["ball"]["shown"]["median_mm"], 2.0);
  EXPECT_DOUBLE_EQ(json["head"]["rms_mm"], 4.0);
  EXPECT_NEAR(json["head"]["rms_deg"], 0.573, 1e-3);
  EXPECT_DOUBLE_EQ(json["shape"]["median_mm"], 3.0);
}

TEST(PredictionLog, HasARowForEachPicture) {
  const ScratchFolder folder;
  auto log = PredictionLog::begin(folder.path(), game());
  ASSERT_TRUE(log) << log.error().message;
  log->add(error_of(7));
  log->add(error_of(8));
  ASSERT_TRUE(log->finish());
  const auto table = read_csv(folder / "realtime_predictions.csv", {.text_columns = {"*"}});
  ASSERT_TRUE(table) << table.error().message;
  ASSERT_EQ(table->rows.size(), 2u);
  const auto cell = [&](std::size_t row, const char* column) {
    return table->text[row][table->require(column).value()];
  };
  EXPECT_EQ(cell(0, "frame"), "7");
  EXPECT_EQ(cell(0, "ahead_ms"), "16");
  EXPECT_EQ(cell(0, "tip_registered_mm"), "30");
  EXPECT_EQ(cell(1, "ball_mm"), "2");
  EXPECT_EQ(cell(1, "bat_2_mm"), "") << "struck meanwhile";
  EXPECT_EQ(cell(0, "shape_mm"), "");
  EXPECT_EQ(cell(1, "shape_mm"), "3");
}

}  // namespace
}  // namespace palpate::server::graphics
