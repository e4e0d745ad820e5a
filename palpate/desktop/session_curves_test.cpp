#include "palpate/desktop/session_curves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/desktop/session_colours.h"

namespace palpate::desktop {
namespace {

using calibration::session::GuidanceState;

std::vector<GuidanceState> falling(int poses) {
  std::vector<GuidanceState> states;
  for (int i = 1; i <= poses; ++i) {
    GuidanceState state;
    state.poses = i;
    state.coverage = i / 27.0;
    state.predicted_error = i < 8 ? std::numeric_limits<double>::quiet_NaN() : 2e-3 / i;
    states.push_back(state);
  }
  return states;
}

TEST(SessionCurves, TellThePredictedErrorAndWhatIsNotVisited) {
  const auto curves = guidance_curves(falling(20), 70);
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_EQ(curves[0].newest, "0.10 mm");
  EXPECT_EQ(curves[1].newest, "26 %");
  EXPECT_NEAR(curves[0].values.back(), 0.1, 1e-12);
  EXPECT_LE(curves[0].low, 0.1);
  EXPECT_GE(curves[0].high, 0.25);
  EXPECT_EQ(guidance_curves(falling(5), 70)[0].newest, "not known yet");
}

TEST(SessionCurves, FallFromLeftToRight) {
  constexpr Box kBox{10, 20, 300, 100};
  for (const auto& curve : guidance_curves(falling(20), 20)) {
    Eigen::Vector2d before(-1e9, -1e9);
    for (std::size_t i = 0; i < curve.values.size(); ++i) {
      if (!std::isfinite(curve.values[i])) continue;
      const auto at = curve_place(curve, i, kBox);
      EXPECT_GT(at.x(), before.x());
      EXPECT_GT(at.y(), before.y()) << curve.title << i;  // down
      EXPECT_GE(at.y(), kBox.y - 1e-9);
      EXPECT_LE(at.y(), kBox.y + kBox.height + 1e-9);
      before = at;
    }
    EXPECT_NEAR(before.x(), 310.0, 1e-9);  // the last pose there will be
  }
}

TEST(SessionCurves, AreAsHighAsTheirScaleSays) {
  Curve curve{"", "", {1.0, 10.0, 100.0}, 3, true, 1.0, 100.0};
  constexpr Box kBox{0, 0, 100, 50};
  EXPECT_TRUE(curve_place(curve, 0, kBox).isApprox(Eigen::Vector2d(0.0, 50.0)));
  EXPECT_TRUE(curve_place(curve, 1, kBox).isApprox(Eigen::Vector2d(50.0, 25.0)));
  EXPECT_NEAR(curve_place(curve, 2, kBox).y(), 0.0, 1e-9);
  curve.logarithmic = false;
  curve.low = 0.0;
  EXPECT_NEAR(curve_place(curve, 1, kBox).y(), 45.0, 1e-9);
}

TEST(SessionCurves, AreDrawnWhereTheyAreAsked) {
  auto lettering = Lettering::open();
  ASSERT_TRUE(lettering);
  Canvas canvas(400, 200);
  draw_curve(canvas, **lettering, guidance_curves(falling(20), 70)[0], {20, 20, 300, 120}, 16);
  int within = 0, line = 0;
  for (int y = 0; y < canvas.height; ++y)
    for (int x = 0; x < canvas.width; ++x) {
      const auto pixel = canvas.at(x, y);
      if (pixel[3] == 0) continue;
      EXPECT_TRUE(x >= 18 && x < 324 && y >= 18 && y < 146) << x << " " << y;
      ++within;
      line += pixel[2] > 200 && pixel[0] < 130;
    }
  EXPECT_GT(within, 500);
  EXPECT_GT(line, 30);
}

}  // namespace
}  // namespace palpate::desktop
