#include "applications/pingpong/report.h"

#include <cmath>

#include "applications/pingpong/record.h"
#include "palpate/figures/impacts.h"

namespace palpate::applications::pingpong {
namespace {

// The player hits the ball within a few frames of flight; a jump farther than this between frames is a new serve.
constexpr double kServeJump = 0.35;  // m

// The ball's path, broken where a serve begins elsewhere.
Json path_of_ball(const CsvTable& ball) {
  if (!figures::has_columns(ball, {"x_m", "y_m", "z_m"})) return nullptr;
  const auto x = figures::column(ball, "x_m"), y = figures::column(ball, "y_m"),
             z = figures::column(ball, "z_m");
  std::vector<double> px, py, pz;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (i > 0 && std::hypot(x[i] - x[i - 1], y[i] - y[i - 1], z[i] - z[i - 1]) > kServeJump) {
      px.push_back(NAN);
      py.push_back(NAN);
      pz.push_back(NAN);
    }
    px.push_back(x[i]);
    py.push_back(y[i]);
    pz.push_back(z[i]);
  }
  return {{"x_m", px}, {"y_m", py}, {"z_m", pz}};
}

}  // namespace

scene::PlayReport play_report(const figures::PlayFolder& play) {
  scene::PlayReport report;
  const CsvTable* ball = play.raw(kBallTable);
  report.data = {{"impulses_are_made_up", true}, {"impacts", figures::impacts(play)}, {"ball", nullptr}};
  if (ball != nullptr) report.data["ball"] = path_of_ball(*ball);
  return report;
}

}  // namespace palpate::applications::pingpong
